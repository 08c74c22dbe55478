#include "client/io/pcd/packed_colors.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "client/io/names/column_names.h"
#include "client/io/writers.h"

namespace curv {
namespace {

using Bytes = std::vector<uint8_t>;

constexpr uint8_t kOpaque = 255;

// In the order of ScalarKind.
constexpr char kTypes[] = {'I', 'U', 'I', 'U', 'I', 'U', 'F', 'F'};

// The names that PCL gives normals.
std::string FieldName(std::string name) {
  for (const auto& [in_table, in_file] : {std::pair("nx", "normal_x"), {"ny", "normal_y"}, {"nz", "normal_z"}}) {
    if (name == in_table) return in_file;
  }
  return name;
}

const Column* FindBytes(const PointTable& table, const char* name) {
  const Column* column = table.Find(name);
  return column != nullptr && column->kind() == ScalarKind::kUint8 ? column : nullptr;
}

// The colors of a table that go into one field.
struct Colors {
  const Column* red;
  const Column* green;
  const Column* blue;
  const Column* alpha;  // null: opaque

  explicit Colors(const PointTable& table)
      : red(FindBytes(table, "red")),
        green(FindBytes(table, "green")),
        blue(FindBytes(table, "blue")),
        alpha(FindBytes(table, "alpha")) {
    const bool is_taken = table.Find("rgb") != nullptr || table.Find("rgba") != nullptr;
    if (is_taken || red == nullptr || green == nullptr || blue == nullptr) red = green = blue = alpha = nullptr;
  }

  bool Has(const Column& column) const {
    return &column == red || &column == green || &column == blue || &column == alpha;
  }

  uint32_t Packed(size_t i) const {
    const auto at = [i](const Column* column) { return uint32_t{std::get<Bytes>(column->values)[i]}; };
    return (alpha == nullptr ? uint32_t{kOpaque} : at(alpha)) << 24 | at(red) << 16 | at(green) << 8 | at(blue);
  }
};

void AddColors(const Colors& colors, bool is_text, PcdFields& fields) {
  const char* name = colors.alpha == nullptr ? "rgb" : "rgba";
  const bool is_float = colors.alpha == nullptr && !is_text;
  fields.fields.push_back({.name = name, .type = is_float ? 'F' : 'U', .bytes = sizeof(uint32_t)});
  const size_t size = colors.red->size();
  fields.made.reserve(1);  // so that it stays where it is
  if (is_text) {
    std::vector<uint32_t> packed(size);
    for (size_t i = 0; i < size; ++i) packed[i] = colors.Packed(i);
    fields.columns.push_back(&fields.made.emplace_back(Column{name, std::move(packed)}));
    return;
  }
  const Column* alpha = colors.alpha;
  if (alpha == nullptr) alpha = &fields.made.emplace_back(Column{"alpha", Bytes(size, kOpaque)});
  fields.columns.insert(fields.columns.end(), {colors.blue, colors.green, colors.red, alpha});
}

// The bits of colors that text has as floats; nothing if one is unknown.
std::optional<std::vector<uint32_t>> BitsOfText(const std::vector<double>& values) {
  std::vector<uint32_t> bits;
  const bool are_integers = std::any_of(values.begin(), values.end(), [](double value) { return value >= 1.0; });
  for (const double value : values) {
    if (std::isnan(value)) return std::nullopt;
    if (!are_integers) {
      bits.push_back(std::bit_cast<uint32_t>(static_cast<float>(value)));
    } else if (value >= 0.0 && value <= 0xffffffff && value == std::floor(value)) {
      bits.push_back(static_cast<uint32_t>(value));
    } else {
      return std::nullopt;
    }
  }
  return bits;
}

// The bits of a column whose values take 4 bytes each, or are those of text.
std::optional<std::vector<uint32_t>> BitsOf(const Column& column) {
  if (const auto* text = std::get_if<std::vector<double>>(&column.values)) return BitsOfText(*text);
  return std::visit(
      [](const auto& values) {
        std::vector<uint32_t> bits(values.size());
        if constexpr (sizeof(values[0]) == sizeof(uint32_t)) {
          std::transform(values.begin(), values.end(), bits.begin(),
                         [](const auto& value) { return std::bit_cast<uint32_t>(value); });
        }
        return bits;
      },
      column.values);
}

}  // namespace

bool IsPackedColor(const PcdField& field) {
  return (field.name == "rgb" || field.name == "rgba") && field.bytes == sizeof(uint32_t) && field.count == 1;
}

std::vector<Column> UnpackColors(const Column& packed) {
  std::vector<Column> colors;
  const std::optional<std::vector<uint32_t>> bits = BitsOf(packed);
  if (!bits.has_value()) return colors;
  for (const auto& [name, shift] : {std::pair("red", 16), {"green", 8}, {"blue", 0}, {"alpha", 24}}) {
    if (name == std::string("alpha") && packed.name != "rgba") continue;
    Bytes bytes(bits->size());
    std::transform(bits->begin(), bits->end(), bytes.begin(),
                   [shift = shift](uint32_t color) { return static_cast<uint8_t>(color >> shift); });
    colors.push_back({name, std::move(bytes)});
  }
  return colors;
}

PcdFields FieldsOf(const PointTable& table, bool is_text) {
  PcdFields fields;
  const Colors colors(table);
  const std::vector<std::string> names = HeaderNames(table, HeaderName);
  for (size_t i = 0; i < names.size(); ++i) {
    const Column& column = table.columns()[i];
    if (&column == colors.red) AddColors(colors, is_text, fields);
    if (colors.Has(column)) continue;
    fields.fields.push_back({.name = FieldName(names[i]),
                             .type = kTypes[static_cast<size_t>(column.kind())],
                             .bytes = static_cast<uint32_t>(BytesOf(column.kind()))});
    fields.columns.push_back(&column);
  }
  return fields;
}

}  // namespace curv
