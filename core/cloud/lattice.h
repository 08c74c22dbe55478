// A grid of positions that all parts of a cloud share.
#pragma once

#include <array>
#include <optional>

#include "absl/status/status.h"

namespace curvd {

// Rounds each coordinate to the nearest multiple of `spacing`, halves to even, before it subtracts the origin, and all of
// it exactly. So the difference of two positions is the same whatever the origin, and a float holds each of them.
struct Lattice {
  // The largest distance of a coordinate from the origin, in spacings: floats hold twice as much.
  static constexpr double kMostSpacings = 0x1p23;
  // Bounds of the spacing: the caller's unit, times or by this.
  static constexpr double kMostSpacing = 0x1p100;
  // The largest coordinate of the origin, in spacings: doubles hold twice as much.
  static constexpr double kMostOrigin = 0x1p52;

  double spacing = 1.0;
  std::array<double, 3> origin{};

  // kInvalid (core/base/error.h), naming the field and its limit, if the spacing is no power of two from
  // 1 / kMostSpacing to kMostSpacing, or a coordinate of the origin is no multiple of it, or above kMostOrigin of it.
  absl::Status Validate() const;

  // The position relative to the origin; nothing where a coordinate is farther than kMostSpacings from it.
  // REQUIRES: Validate() is OK; the position is finite.
  std::optional<std::array<float, 3>> Place(const std::array<double, 3>& position) const;
};

}  // namespace curvd
