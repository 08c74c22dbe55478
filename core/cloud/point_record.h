// A point's position with its index, on its way from a cloud into the tree.
#pragma once

#include <cstddef>
#include <cstdint>

namespace curvd {

struct PointRecord {
  float position[3];
  int32_t id;
};

// Records that a leaf of the tree takes: arrays of records are made for whole leaves, so that the tree can have them.
inline constexpr size_t kLeafRecords = 16;  // one AVX-512 vector of a coordinate, two of AVX2

}  // namespace curvd
