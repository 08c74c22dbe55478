#include "client/report/thinning.h"

#include <algorithm>
#include <limits>

namespace curv {

// Shifts and odd factors alone, each of which can be undone: a bijection.
uint32_t IndexHash(uint32_t index) {
  uint32_t hash = index;
  hash = (hash ^ (hash >> 16)) * 0x9e3779b1u;
  hash = (hash ^ (hash >> 15)) * 0x85ebca6bu;
  return hash ^ (hash >> 16);
}

Thinning ChoosePoints(size_t size, size_t most) {
  Thinning thinning{.limit = std::numeric_limits<uint32_t>::max(), .chosen = {}};
  const uint32_t count = static_cast<uint32_t>(size);
  if (size > most) {
    std::vector<uint32_t> hashes(size);
    for (uint32_t i = 0; i < count; ++i) hashes[i] = IndexHash(i);
    const auto last = hashes.begin() + static_cast<ptrdiff_t>(most - 1);
    std::nth_element(hashes.begin(), last, hashes.end());
    thinning.limit = *last;
  }
  thinning.chosen.reserve(std::min(size, most));
  for (uint32_t i = 0; i < count; ++i) {
    if (IndexHash(i) <= thinning.limit) thinning.chosen.push_back(i);
  }
  return thinning;
}

}  // namespace curv
