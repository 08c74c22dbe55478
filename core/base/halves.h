// Two halves of a cloud, by a hash of the points' indices: estimates from one each have independent noise.
#pragma once

#include <cstdint>

namespace curvd {

enum class Half : uint8_t { kEven, kOdd };

// The finalizer of MurmurHash3: each bit of the index changes each bit of the hash half of the time.
inline constexpr uint32_t kHalfMultipliers[2] = {0x85ebca6bU, 0xc2b2ae35U};
inline constexpr int kHalfShifts[3] = {16, 13, 16};

// Which half a point of this index in the cloud belongs to.
inline Half HalfOf(int32_t id) {
  auto hash = static_cast<uint32_t>(id);
  hash = (hash ^ hash >> kHalfShifts[0]) * kHalfMultipliers[0];
  hash = (hash ^ hash >> kHalfShifts[1]) * kHalfMultipliers[1];
  return ((hash ^ hash >> kHalfShifts[2]) & 1) == 0 ? Half::kEven : Half::kOdd;
}

}  // namespace curvd
