// Turns results into columns of a file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/curvature_client.h"
#include "client/io/point_table.h"
#include "client/render/color_scale.h"

namespace curv {

// The quantities that can be drawn or colored, and the words for them in --quantity and --color.
struct NamedQuantity {
  const char* word;          // "mean"
  const char* column;        // "mean_curvature"
  const char* truth_column;  // "true_mean"
  const char* title;         // "Mean curvature"
  const char* unit;          // "1/%", where % stands for the cloud's length unit
};
inline constexpr NamedQuantity kQuantities[] = {
    {"mean", "mean_curvature", "true_mean", "Mean curvature", "1/%"},
    {"gaussian", "gaussian_curvature", "true_gaussian", "Gaussian curvature", "1/%\u00b2"},
    {"k1", "k1", "true_k1", "Principal curvature k\u2081", "1/%"},
    {"k2", "k2", "true_k2", "Principal curvature k\u2082", "1/%"},
};
inline constexpr char kQuantityWords[] = "mean, gaussian, k1, k2";

// Returns the quantity of that word, or nullptr.
const NamedQuantity* FindQuantity(const std::string& word);
// Returns the quantity whose estimate has a column of that name, or nullptr.
const NamedQuantity* QuantityOfColumn(const std::string& column);

// The quantities that `curv estimate --quantities` asks for by a short word, and the contract's name of each; the
// contract's own names are understood as well.
std::vector<std::string> QuantityWords();
// The contract's name for a word of QuantityWords().
std::string ContractName(const std::string& word);

// Whether quantities, by the contract's names, are not those of normals alone; an empty list asks for curvature.
bool AskForCurvature(const std::vector<std::string>& quantities);

// Returns the columns x y z nx ny nz mean_curvature gaussian_curvature k1 k2 d1x d1y d1z d2x d2y d2z radius, as far as
// the result has them, then what else it has, then status, then the other columns of `input`. Those that results can
// have are dropped from the input, asked for or not: they are of an earlier estimate. Normals are those of the result,
// or else of the input. REQUIRES: `input` has positions, and as many points as `result`.
PointTable MakeResultTable(PointTable input, CurvatureResult result);

// What the names of columns end in that are of one of several neighbor counts: mean_curvature_k64.
std::string ScaleSuffix(uint32_t neighbor_count);
// A name without that suffix, if it has one.
std::string WithoutScale(const std::string& name);

// The columns of a result alone, in that order: those that were asked for, and the status. With several neighbor
// counts, those of each follow one another, the normals' before them.
std::vector<Column> ColumnsOf(CurvatureResult result);
// The same table as MakeResultTable's of the results that ColumnsOf returned. REQUIRES: the columns have as many
// points.
PointTable JoinResults(PointTable input, std::vector<Column> results);

// What to note of an input with columns of these names: which of them MakeResultTable drops. Empty if it drops none.
std::string NoteOnDroppedColumns(const std::vector<std::string>& names);
// The same of a table.
std::string NoteOnDroppedColumns(const PointTable& input);

// Adds the columns red, green and blue for the values of a column, and returns the scale of the colors.
// REQUIRES: the table has the column.
ColorScale AddColors(const std::string& column, PointTable& table);

// Returns a column as doubles. REQUIRES: the table has it.
std::vector<double> ValuesOf(const PointTable& table, const std::string& column);

}  // namespace curv
