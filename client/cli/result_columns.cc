#include "client/cli/result_columns.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/io/text.h"
#include "proto/result_columns.h"

namespace curv {
namespace {

std::vector<float> Component(const std::vector<float>& vectors, size_t axis) {
  std::vector<float> component(vectors.size() / 3);
  for (size_t i = 0; i < component.size(); ++i) component[i] = vectors[3 * i + axis];
  return component;
}

// What was not asked for is empty and is left out. Vectors are three columns, whose names have x, y and z before the
// suffix.
void AddFloats(const std::string& name, size_t width, std::vector<float> values, const std::string& suffix,
               std::vector<Column>& columns) {
  if (values.empty()) return;
  if (width != 3) {
    columns.push_back({name + suffix, std::move(values)});
    return;
  }
  for (const size_t axis : {0, 1, 2}) columns.push_back({name + "xyz"[axis] + suffix, Component(values, axis)});
}

void AddOther(NamedColumn column, const std::string& suffix, std::vector<Column>& columns) {
  if (auto* floats = std::get_if<std::vector<float>>(&column.values)) {
    AddFloats(column.name, column.width, std::move(*floats), suffix, columns);
  } else {
    columns.push_back({column.name + suffix, std::get<std::vector<uint8_t>>(std::move(column.values))});
  }
}

// Files call the normal n: nx, ny, nz.
std::string FileName(std::string_view member) { return member == "normal" ? "n" : std::string(member); }

// Adds all but the scales.
void AddResult(CurvatureResult result, const std::string& suffix, std::vector<Column>& columns) {
  for (const ResultMember& member : ResultMembers()) {
    AddFloats(FileName(member.name), member.width, std::move(result.*member.values), suffix, columns);
  }
  for (NamedColumn& other : result.others) AddOther(std::move(other), suffix, columns);
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

const NamedQuantity* QuantityOfColumn(const std::string& column) {
  const auto* found = std::find_if(std::begin(kQuantities), std::end(kQuantities),
                                   [&](const NamedQuantity& quantity) { return column == quantity.column; });
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

bool AskForCurvature(const std::vector<std::string>& quantities) {
  const auto is_of_curvature = [](const std::string& name) { return name != "normals" && name != "normal_quality"; };
  return quantities.empty() || std::any_of(quantities.begin(), quantities.end(), is_of_curvature);
}

std::string ScaleSuffix(uint32_t neighbor_count) { return absl::StrCat("_k", neighbor_count); }

std::string WithoutScale(const std::string& name) {
  const size_t end = name.find_last_not_of("0123456789");
  const bool has_suffix =
      end != std::string::npos && end >= 1 && end + 1 < name.size() && name[end] == 'k' && name[end - 1] == '_';
  return has_suffix ? name.substr(0, end - 1) : name;
}

std::vector<Column> ColumnsOf(CurvatureResult result) {
  std::vector<Column> columns;
  std::vector<CurvatureResult> scales = std::move(result.scales);
  std::vector<uint8_t> status = std::move(result.status);
  AddResult(std::move(result), "", columns);
  if (scales.empty()) columns.push_back({"status", std::move(status)});
  for (CurvatureResult& scale : scales) {
    const std::string suffix = ScaleSuffix(scale.neighbor_count);
    std::vector<uint8_t> scale_status = std::move(scale.status);
    AddResult(std::move(scale), suffix, columns);
    columns.push_back({"status" + suffix, std::move(scale_status)});
  }
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
  table.pcd = input.pcd;
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) Move(columns, name, table);
  for (Column& column : results) table.Set(std::move(column));  // normals in the place of the input's
  // An earlier estimate must not stand beside this one as if it were a part of it.
  const std::set<std::string> result_names = ResultNames();
  for (Column& column : columns) {
    if (!result_names.contains(WithoutScale(column.name))) table.Set(std::move(column));
  }
  return table;
}

std::string NoteOnDroppedColumns(const std::vector<std::string>& names) {
  const std::set<std::string> result_names = ResultNames();
  std::vector<std::string> dropped;
  for (const std::string& name : names) {
    if (result_names.contains(WithoutScale(name))) dropped.push_back(Printable(name));
  }
  if (dropped.empty()) return "";
  return absl::StrCat("left out columns that are named like results: ", absl::StrJoin(dropped, ", "));
}

std::string NoteOnDroppedColumns(const PointTable& input) {
  std::vector<std::string> names;
  for (const Column& column : input.columns()) names.push_back(column.name);
  return NoteOnDroppedColumns(names);
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
