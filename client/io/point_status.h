// Names what became of a point, in files and on the screen.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace curv {

// The values are those of curvature.v1.PointStatus, and what PLY files hold in their `status` property.
enum class PointStatus : uint8_t {
  kOk = 1,
  kTooFewNeighbors = 2,
  kDegenerateArea = 3,
  kInvalidInput = 4,
  kInconsistentNormals = 5,
  kSingularFit = 6,
  kOpposedNormals = 7,
  kOutlier = 8,
};

// The word for each value. Value 0 is never used.
inline constexpr std::array<std::string_view, 9> kStatusWords = {
    "unspecified",          "ok",           "too_few_neighbors", "degenerate_area", "invalid_input",
    "inconsistent_normals", "singular_fit", "opposed_normals",   "outlier"};

// Returns the word for a value, or "unknown" if it has none.
constexpr std::string_view StatusWord(uint8_t value) {
  return value < kStatusWords.size() ? kStatusWords[value] : std::string_view("unknown");
}

// Returns the value that has this word, if one has.
constexpr std::optional<uint8_t> StatusOfWord(std::string_view word) {
  for (size_t value = 0; value < kStatusWords.size(); ++value) {
    if (kStatusWords[value] == word) return static_cast<uint8_t>(value);
  }
  return std::nullopt;
}

// Whether a column of this name says what became of each point: "status", or with several neighbor counts "status_k64".
constexpr bool IsStatusName(std::string_view name) {
  constexpr std::string_view kName = "status", kScale = "_k";
  if (name.substr(0, kName.size()) != kName) return false;
  name.remove_prefix(kName.size());
  if (name.empty()) return true;
  return name.substr(0, kScale.size()) == kScale && name.size() > kScale.size() &&
         name.find_first_not_of("0123456789", kScale.size()) == std::string_view::npos;
}

}  // namespace curv
