#include "client/neighbors/spatial_order.h"

#include <algorithm>
#include <cstddef>

namespace curv {
namespace {

constexpr int kCellBits = 10;  // for each axis

// Puts two zeros between the lowest ten bits.
uint32_t SpreadBits(uint32_t bits) {
  bits = (bits | (bits << 16)) & 0x030000ffu;
  bits = (bits | (bits << 8)) & 0x0300f00fu;
  bits = (bits | (bits << 4)) & 0x030c30c3u;
  return (bits | (bits << 2)) & 0x09249249u;
}

}  // namespace

std::vector<uint32_t> SpatialOrder(const std::vector<Vec3>& positions) {
  if (positions.empty()) return {};
  Vec3 low = positions.front(), high = low;
  for (const Vec3& p : positions) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
  // Halves, so that no difference overflows.
  const Vec3 extent = 0.5 * high - 0.5 * low;
  const double longest = std::max({extent.x, extent.y, extent.z});
  constexpr double kLastCell = (1 << kCellBits) - 1;
  std::vector<uint64_t> keys(positions.size());  // the cell above, the index below
  for (size_t i = 0; i < positions.size(); ++i) {
    uint32_t cell = 0;
    for (int axis = 0; axis < 3 && longest > 0.0; ++axis) {
      const double share = (0.5 * positions[i][axis] - 0.5 * low[axis]) / longest;
      cell |= SpreadBits(static_cast<uint32_t>(kLastCell * share)) << axis;
    }
    keys[i] = uint64_t{cell} << 32 | i;
  }
  std::sort(keys.begin(), keys.end());
  std::vector<uint32_t> order(positions.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<uint32_t>(keys[i]);
  return order;
}

}  // namespace curv
