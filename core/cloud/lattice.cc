#include "core/cloud/lattice.h"

#include <cmath>

#include "absl/strings/str_format.h"
#include "core/base/error.h"

namespace curvd {

absl::Status Lattice::Validate() const {
  int exponent = 0;
  const bool is_in_range = spacing >= 1.0 / kMostSpacing && spacing <= kMostSpacing;
  if (!is_in_range || std::frexp(spacing, &exponent) != 0.5) {
    return MakeCoreError(
        ErrorKind::kInvalid,
        absl::StrFormat("lattice.spacing is %.17g; it must be a power of two from 2^-100 to 2^100", spacing));
  }
  for (size_t axis = 0; axis < 3; ++axis) {
    const double spacings = origin[axis] / spacing;  // exact, or too large
    if (std::abs(spacings) <= kMostOrigin && std::nearbyint(spacings) == spacings) continue;
    return MakeCoreError(ErrorKind::kInvalid,
                         absl::StrFormat("lattice.origin.%c is %.17g; it must be a whole multiple of lattice.spacing, "
                                         "%.17g, and at most 2^52 of it",
                                         "xyz"[axis], origin[axis], spacing));
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
