#include "client/io/names/columns_by_place.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "absl/strings/str_cat.h"

namespace curv {
namespace {

// Why columns 4 to 6 are no normals; empty if they are, which are unit vectors, written with few digits maybe. Others
// are intensities and colors, as PTS files have them. A vector of zeros says nothing.
std::string WhyNoNormals(NoVectors no_vectors, const std::vector<Column>& columns) {
  constexpr double kSlack = 0.1;
  bool any = no_vectors == NoVectors::kAreNormals;
  for (size_t row = 0; row < columns[0].size(); ++row) {
    const double length = std::hypot(columns[3].At(row), columns[4].At(row), columns[5].At(row));
    if (length == 0.0 || std::isnan(length)) continue;
    if (std::abs(length - 1.0) > kSlack) return absl::StrCat("the vector of point ", row, " has the length ", length);
    any = true;
  }
  return any ? "" : "no point has a vector there";
}

// Whether columns 4 to 6 of exactly six hold colors rather than normals.
bool HoldColors(const std::vector<Column>& columns) {
  if (columns.size() != 6) return false;
  bool above_one = false;
  for (size_t c = 3; c < 6; ++c) {
    for (size_t row = 0; row < columns[c].size(); ++row) {
      const double value = columns[c].At(row);
      if (!(value >= 0.0 && value <= 255.0) || value != static_cast<uint8_t>(value)) return false;
      above_one |= value > 1.0;
    }
  }
  return above_one;
}

Column ToColor(const Column& column, const char* name) {
  std::vector<uint8_t> values(column.size());
  for (size_t row = 0; row < values.size(); ++row) values[row] = static_cast<uint8_t>(column.At(row));
  return {name, std::move(values)};
}

}  // namespace

void NameByPlace(NoVectors no_vectors, std::string_view remedy, std::vector<Column>& columns,
                 std::vector<std::string>& notes) {
  static constexpr const char* kNames[] = {"x", "y", "z", "nx", "ny", "nz"};
  static constexpr const char* kColorNames[] = {"red", "green", "blue"};
  const bool has_points = !columns.empty() && columns.front().size() > 0;
  const bool colors = HoldColors(columns);
  const std::string why =
      has_points && columns.size() >= 6 && !colors ? WhyNoNormals(no_vectors, columns) : std::string();
  const size_t known = columns.size() >= 6 && why.empty() ? 6 : 3;
  for (size_t i = 0; i < columns.size(); ++i) {
    columns[i].name = i < known ? kNames[i] : absl::StrCat("column", i + 1);
    if (colors && i >= 3) columns[i] = ToColor(columns[i], kColorNames[i - 3]);
  }
  if (why.empty()) return;
  notes.push_back(absl::StrCat("columns 4 to 6 are no normals: ", why, ". If they are, ", std::string(remedy)));
}

}  // namespace curv
