// A point as the store of a plan keeps it.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>

#include "client/tiles/box.h"

namespace curv {

struct TilePoint {
  Position position{};
  std::array<float, 3> normal{};
  uint64_t id = 0;  // its place in the input, all files one after the other
};

// The bytes that a point takes in a store of floats, or of doubles.
constexpr size_t StoredBytes(bool is_double) { return is_double ? 44 : 32; }

// Writes the StoredBytes of a point; floats hold a position that is one of floats.
inline void PackPoint(const TilePoint& point, bool is_double, char* out) {
  if (is_double) {
    std::memcpy(out, point.position.data(), 24);
    out += 24;
  } else {
    const std::array<float, 3> position = {static_cast<float>(point.position[0]), static_cast<float>(point.position[1]),
                                           static_cast<float>(point.position[2])};
    std::memcpy(out, position.data(), 12);
    out += 12;
  }
  std::memcpy(out, point.normal.data(), 12);
  std::memcpy(out + 12, &point.id, 8);
}

inline TilePoint UnpackPoint(const char* bytes, bool is_double) {
  TilePoint point;
  if (is_double) {
    std::memcpy(point.position.data(), bytes, 24);
    bytes += 24;
  } else {
    std::array<float, 3> position;
    std::memcpy(position.data(), bytes, 12);
    bytes += 12;
    for (size_t axis = 0; axis < 3; ++axis) point.position[axis] = position[axis];
  }
  std::memcpy(point.normal.data(), bytes, 12);
  std::memcpy(&point.id, bytes + 12, 8);
  return point;
}

}  // namespace curv
