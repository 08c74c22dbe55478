#include "bench/peers/morton_order.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace curvd::bench {
namespace {

constexpr uint32_t kCells = 1024;  // an axis; ten bits

struct Keyed {
  uint32_t key;
  uint32_t index;
};

// Moves bit i to bit 3 i, for the low ten bits.
uint32_t Spread(uint32_t bits) {
  bits = (bits | bits << 16) & 0x030000ff;
  bits = (bits | bits << 8) & 0x0300f00f;
  bits = (bits | bits << 4) & 0x030c30c3;
  return (bits | bits << 2) & 0x09249249;
}

std::vector<Keyed> MortonKeys(std::span<const float> positions) {
  std::array<float, 3> lo, hi;
  lo.fill(std::numeric_limits<float>::max());
  hi.fill(std::numeric_limits<float>::lowest());
  for (size_t i = 0; i < positions.size(); i += 3) {
    for (size_t axis = 0; axis < 3; ++axis) {
      lo[axis] = std::min(lo[axis], positions[i + axis]);
      hi[axis] = std::max(hi[axis], positions[i + axis]);
    }
  }
  const float extent = std::max({hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]});
  const float scale = extent > 0.0f ? static_cast<float>(kCells) / extent : 0.0f;
  std::vector<Keyed> keys(positions.size() / 3);
  for (uint32_t i = 0; i < keys.size(); ++i) {
    uint32_t key = 0;
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<uint32_t>((positions[3 * size_t{i} + axis] - lo[axis]) * scale);
      key |= Spread(std::min(cell, kCells - 1)) << axis;
    }
    keys[i] = {key, i};
  }
  return keys;
}

}  // namespace

std::vector<uint32_t> MortonOrder(std::span<const float> positions) {
  std::vector<Keyed> keys = MortonKeys(positions), sorted(keys.size());
  for (int shift = 0; shift < 30; shift += 10) {
    std::array<size_t, 1024> next{};
    for (const Keyed& entry : keys) ++next[entry.key >> shift & 1023];
    size_t sum = 0;
    for (size_t& first : next) sum += std::exchange(first, sum);
    for (const Keyed& entry : keys) sorted[next[entry.key >> shift & 1023]++] = entry;
    keys.swap(sorted);
  }
  std::vector<uint32_t> order(keys.size());
  for (size_t i = 0; i < keys.size(); ++i) order[i] = keys[i].index;
  return order;
}

}  // namespace curvd::bench
