// Encodes where the points of a report are, and how they lie.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "client/io/point_table.h"
#include "client/render/pose.h"
#include "client/report/payload.h"

namespace curv {

// The bounding box of all points with finite positions, in the file's coordinates.
struct Bounds {
  std::array<double, 3> low;
  std::array<double, 3> high;
  size_t finite = 0;  // how many points there are; without any, low and high mean nothing
};
Bounds BoundsOf(const PointTable& table);

// Codes of coordinates go from 0 at the box's low end to this at its high end; one more for a point that is nowhere.
inline constexpr uint16_t kLargestPlace = 65534;
inline constexpr uint16_t kNowhere = 65535;

// What the page needs to know of the arrays that AppendPoints adds.
struct EncodedPoints {
  double largest_radius = 0.0;  // of a splat, where the box's longest side is 1
  size_t nowhere = 0;           // chosen points without a finite position
  bool has_normals = false;     // of the file, or made of its directions
  bool has_directions = false;
};

// How large splats are, where the points are not all that are shown.
struct SplatSizes {
  double share = 1.0;    // of what is shown: radii shrink with its root, as if the others lay between the points
  double largest = 0.0;  // radii are cut to it and told relative to it; DEFAULT: the largest of the points
};

// Adds the arrays x y z; radius8, from which the radius of a splat is largest_radius * 2^(-code / 16), the distance to
// the sixth neighbor among the chosen points (DiscRadii); normal_u normal_v (OctahedralCode, as unsigned bits) and
// angle of d1 (AngleCode, to that normal), where the table has them. A point whose status is not ok has no direction.
// REQUIRES: bounds.finite > 0; the table has x y z; `chosen` are indices of points.
EncodedPoints AppendPoints(const PointTable& table, const std::vector<uint32_t>& chosen, const Bounds& bounds,
                           const std::vector<uint8_t>& statuses, Payload& payload, const SplatSizes& sizes = {});

// How the chosen points are shown at first (ChoosePose), by their normals where the table has them.
Pose PoseOf(const PointTable& table, const std::vector<uint32_t>& chosen, std::optional<char> up_axis);

}  // namespace curv
