// Points of float32 input, checked and brought to unit normals by vectors.
#pragma once

#include <cstddef>
#include <cstdint>

namespace curvd {

// Up to 64 points at once.
struct UnitNormals {
  static constexpr size_t kMaxPoints = 64;

  float normals[kMaxPoints][3];  // of unit length; undefined for points that are not usable
  uint64_t usable;               // as bits: position and normal are finite, the normal is not zero
  uint64_t rescaled;             // as bits: the normal's length was off by more than the tolerance
};

// `positions` and `normals` hold 3 * count packed floats each; they need no alignment. A normal is divided by its
// length in doubles, and rounded once. REQUIRES: count <= UnitNormals::kMaxPoints.
void MakeUnitNormals(const char* positions, const char* normals, size_t count, double unit_tolerance, UnitNormals& out);

}  // namespace curvd
