// Results as columns of a file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/curvature_client.h"
#include "client/io/point_table.h"
#include "client/render/color_scale.h"

namespace curv {

// Quantities that can be drawn or colored, by the words of --quantity and --color.
struct NamedQuantity {
  const char* word;          // "mean"
  const char* column;        // "mean_curvature"
  const char* truth_column;  // "true_mean"
  const char* title;         // "mean curvature"
};
inline constexpr NamedQuantity kQuantities[] = {
    {"mean", "mean_curvature", "true_mean", "mean curvature"},
    {"gaussian", "gaussian_curvature", "true_gaussian", "Gaussian curvature"},
    {"k1", "k1", "true_k1", "principal curvature k1"},
    {"k2", "k2", "true_k2", "principal curvature k2"},
};
inline constexpr char kQuantityWords[] = "mean, gaussian, k1, k2";

// The quantity of that word, or nothing.
const NamedQuantity* FindQuantity(const std::string& word);

// The quantities that `curv estimate --quantities` asks for by a short word, and the contract's name of each; the
// contract's own names are understood as well.
std::vector<std::string> QuantityWords();
// The contract's name for a word of QuantityWords().
std::string ContractName(const std::string& word);

// Returns the columns x y z nx ny nz mean_curvature gaussian_curvature k1 k2 d1x d1y d1z d2x d2y d2z radius, as far as
// the result has them, then what else it has, then status, then the other columns of `input`, save those whose names
// are taken. REQUIRES: `input` has positions and normals, and as many points as `result`.
PointTable MakeResultTable(PointTable input, CurvatureResult result);

// Adds red, green and blue for the values of a column; the range of colors is returned.
// REQUIRES: the table has the column.
ColorScale AddColors(const std::string& column, PointTable& table);

// A column as doubles. REQUIRES: the table has it.
std::vector<double> ValuesOf(const PointTable& table, const std::string& column);

}  // namespace curv
