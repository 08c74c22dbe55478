// Chooses the points of a large cloud that a report holds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace curv {

// Mixes an index so that neighbors in a file are no neighbors any more. No two indices have the same hash.
uint32_t IndexHash(uint32_t index);

// A choice of points that depends on their indices alone, so that whoever knows `limit` can make it again.
struct Thinning {
  uint32_t limit;                // a point is chosen if its hash is at most this
  std::vector<uint32_t> chosen;  // in ascending order
};

// Chooses `most` of `size` points, or all if there are no more. REQUIRES: 1 <= size <= 2^32 - 1, most >= 1.
Thinning ChoosePoints(size_t size, size_t most);

}  // namespace curv
