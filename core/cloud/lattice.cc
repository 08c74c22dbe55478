#include "core/cloud/lattice.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "core/base/error.h"
#include "core/base/number_text.h"

namespace curvd {

absl::Status Lattice::Validate() const {
  int exponent = 0;
  const bool is_in_range = spacing >= 1.0 / kMostSpacing && spacing <= kMostSpacing;
  if (!is_in_range || std::frexp(spacing, &exponent) != 0.5) {
    return InvalidValue("lattice.spacing", NumberText(spacing), "a power of two from 2^-100 to 2^100");
  }
  for (size_t axis = 0; axis < 3; ++axis) {
    const double spacings = origin[axis] / spacing;  // exact, or too large
    if (std::abs(spacings) <= kMostOrigin && std::nearbyint(spacings) == spacings) continue;
    constexpr const char* kFields[] = {"lattice.origin.x", "lattice.origin.y", "lattice.origin.z"};
    return InvalidValue(
        kFields[axis], NumberText(origin[axis]),
        absl::StrCat("a whole multiple of lattice.spacing, ", NumberText(spacing), ", and at most 2^52 of it"));
  }
  return absl::OkStatus();
}

std::optional<std::array<float, 3>> Lattice::Place(const std::array<double, 3>& position) const {
  std::array<float, 3> placed;
  for (size_t axis = 0; axis < 3; ++axis) {
    // A quotient that is no double is too large, and a difference is exact where it is small enough.
    const double spacings = std::nearbyint(position[axis] / spacing) - origin[axis] / spacing;
    if (!(std::abs(spacings) <= kMostSpacings)) return std::nullopt;
    placed[axis] = static_cast<float>(spacings * spacing);
  }
  return placed;
}

}  // namespace curvd
