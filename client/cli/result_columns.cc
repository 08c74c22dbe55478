#include "client/cli/result_columns.h"

#include <algorithm>
#include <set>
#include <utility>

#include "proto/result_columns.h"

namespace curv {
namespace {

std::vector<float> Component(const std::vector<float>& vectors, size_t axis) {
  std::vector<float> component(vectors.size() / 3);
  for (size_t i = 0; i < component.size(); ++i) component[i] = vectors[3 * i + axis];
  return component;
}

// What was not asked for is empty and is left out.
void AddScalars(const std::string& name, std::vector<float> scalars, std::vector<Column>& columns) {
  if (!scalars.empty()) columns.push_back({name, std::move(scalars)});
}

void AddVector(const std::string& name, const std::vector<float>& vectors, std::vector<Column>& columns) {
  if (vectors.empty()) return;
  columns.push_back({name + "x", Component(vectors, 0)});
  columns.push_back({name + "y", Component(vectors, 1)});
  columns.push_back({name + "z", Component(vectors, 2)});
}

void AddOther(NamedColumn column, std::vector<Column>& columns) {
  auto* floats = std::get_if<std::vector<float>>(&column.values);
  if (floats == nullptr) {
    columns.push_back({column.name, std::get<std::vector<uint8_t>>(std::move(column.values))});
  } else if (column.width == 3) {
    AddVector(column.name, *floats, columns);
  } else {
    AddScalars(column.name, std::move(*floats), columns);
  }
}

// The names of all columns that a result can have in a file, but for normals, which input may have.
std::set<std::string> ResultNames() {
  std::set<std::string> names;
  for (const curvature::wire::ResultColumn& column : curvature::wire::ResultColumns()) {
    if (column.quantity == curvature::v1::QUANTITY_NORMALS) continue;
    if (column.width == 3) {
      names.insert({column.name + "x", column.name + "y", column.name + "z"});
    } else {
      names.insert(column.name);
    }
  }
  return names;
}

constexpr std::pair<const char*, const char*> kShortWords[] = {
    {"mean", "mean_curvature"},     {"gaussian", "gaussian_curvature"}, {"k1", "principal_curvatures"},
    {"k2", "principal_curvatures"}, {"d1", "principal_directions"},     {"d2", "principal_directions"},
};

void Move(std::vector<Column>& columns, const char* name, PointTable& table) {
  const auto found = std::find_if(columns.begin(), columns.end(), [&](const Column& c) { return c.name == name; });
  if (found == columns.end()) return;
  table.Set(std::move(*found));
  columns.erase(found);
}

}  // namespace

const NamedQuantity* FindQuantity(const std::string& word) {
  const auto* found = std::find_if(std::begin(kQuantities), std::end(kQuantities),
                                   [&](const NamedQuantity& quantity) { return word == quantity.word; });
  return found == std::end(kQuantities) ? nullptr : found;
}

std::vector<std::string> QuantityWords() {
  std::vector<std::string> words;
  for (const auto& [word, name] : kShortWords) words.emplace_back(word);
  words.insert(words.end(), QuantityNames().begin(), QuantityNames().end());
  return words;
}

std::string ContractName(const std::string& word) {
  for (const auto& [short_word, name] : kShortWords) {
    if (word == short_word) return name;
  }
  return word;
}

std::vector<Column> ColumnsOf(CurvatureResult result) {
  std::vector<Column> columns;
  AddVector("n", result.normals, columns);
  AddScalars("mean_curvature", std::move(result.mean), columns);
  AddScalars("gaussian_curvature", std::move(result.gaussian), columns);
  AddScalars("k1", std::move(result.k1), columns);
  AddScalars("k2", std::move(result.k2), columns);
  AddVector("d1", result.d1, columns);
  AddVector("d2", result.d2, columns);
  AddScalars("radius", std::move(result.radius), columns);
  AddScalars("normal_residual", std::move(result.normal_residual), columns);
  AddScalars("normal_variance_ratio", std::move(result.normal_variance_ratio), columns);
  AddScalars("shape_index", std::move(result.shape_index), columns);
  AddScalars("curvedness", std::move(result.curvedness), columns);
  AddScalars("mean_curvature_standard_error", std::move(result.mean_standard_error), columns);
  AddScalars("k1_standard_error", std::move(result.k1_standard_error), columns);
  AddScalars("k2_standard_error", std::move(result.k2_standard_error), columns);
  AddScalars("chosen_neighbor_count", std::move(result.chosen_neighbor_count), columns);
  AddScalars("avg_hexagram_weight", std::move(result.avg_hexagram_weight), columns);
  AddScalars("normal_regression_weight", std::move(result.normal_regression_weight), columns);
  AddScalars("jet_weight", std::move(result.jet_weight), columns);
  AddScalars("normal_curvature", std::move(result.normal_curvature), columns);
  for (NamedColumn& other : result.others) AddOther(std::move(other), columns);
  columns.push_back({"status", std::move(result.status)});
  return columns;
}

PointTable MakeResultTable(PointTable input, CurvatureResult result) {
  return JoinResults(std::move(input), ColumnsOf(std::move(result)));
}

PointTable JoinResults(PointTable input, std::vector<Column> results) {
  std::vector<Column> columns = input.Release();
  PointTable table;
  table.las = std::move(input.las);
  table.viewpoint = input.viewpoint;
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) Move(columns, name, table);
  for (Column& column : results) table.Set(std::move(column));  // normals in the place of the input's
  // An earlier estimate must not stand beside this one as if it were a part of it.
  const std::set<std::string> result_names = ResultNames();
  for (Column& column : columns) {
    if (!result_names.contains(column.name)) table.Set(std::move(column));
  }
  return table;
}

std::vector<double> ValuesOf(const PointTable& table, const std::string& column) {
  return std::visit([](const auto& values) { return std::vector<double>(values.begin(), values.end()); },
                    table.Find(column)->values);
}

ColorScale AddColors(const std::string& column, PointTable& table) {
  const std::vector<double> values = ValuesOf(table, column);
  const ColorScale scale = ColorScale::ForValues(values);
  std::vector<uint8_t> red, green, blue;
  for (const double value : values) {
    const Color color = scale.ColorOf(value);
    red.push_back(ToByte(color.red));
    green.push_back(ToByte(color.green));
    blue.push_back(ToByte(color.blue));
  }
  table.Set({"red", std::move(red)});
  table.Set({"green", std::move(green)});
  table.Set({"blue", std::move(blue)});
  return scale;
}

}  // namespace curv
