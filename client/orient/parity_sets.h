// Keeps sets of points that are known to agree or disagree with each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace curv {

// Disjoint sets in which each element is known to be equal or opposite to the set's root. Not thread-safe.
class ParitySets {
 public:
  // REQUIRES: size < 2^32.
  explicit ParitySets(size_t size) : parents_(size), sizes_(size, 1), opposite_(size) {
    std::iota(parents_.begin(), parents_.end(), 0u);
  }

  struct Place {
    uint32_t root;
    bool opposite;  // to the root
  };
  Place Find(uint32_t element) const {
    Place place{element, false};
    while (parents_[place.root] != place.root) {
      place.opposite ^= opposite_[place.root] != 0;
      place.root = parents_[place.root];
    }
    return place;
  }

  // Makes the way from each element to its root one step. Changes no root and no opposite.
  void Flatten() {
    for (uint32_t element = 0; element < parents_.size(); ++element) {
      const Place place = Find(element);
      parents_[element] = place.root;
      opposite_[element] = place.opposite ? 1 : 0;
    }
  }

  // Joins the sets of a and b, which are opposite or equal to each other. No effect within one set.
  void Join(uint32_t a, uint32_t b, bool opposite) {
    Place x = Find(a), y = Find(b);
    if (x.root == y.root) return;
    // The smaller goes below the larger: ways to the root stay short.
    if (sizes_[x.root] < sizes_[y.root]) std::swap(x, y);
    parents_[y.root] = x.root;
    sizes_[x.root] += sizes_[y.root];
    opposite_[y.root] = static_cast<uint8_t>(x.opposite ^ y.opposite ^ opposite);
  }

 private:
  std::vector<uint32_t> parents_;
  std::vector<uint32_t> sizes_;
  std::vector<uint8_t> opposite_;  // to the parent
};

}  // namespace curv
