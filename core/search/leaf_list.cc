#include "core/search/leaf_list.h"

#include <limits>

namespace curvd {

void LeafList::Grow(size_t size) {
  leaves_.Reserve(size + kPad);
  for (auto& bound : bounds_) bound.Reserve(size + kPad);
}

void LeafList::Add(const SpatialIndex& index, uint32_t leaf) {
  Reserve(size_ + 1);
  *end() = leaf;
  for (int axis = 0; axis < 3; ++axis) {
    *lo_end(axis) = index.leaf_lo(axis)[leaf];
    *hi_end(axis) = index.leaf_hi(axis)[leaf];
  }
  Keep(1);
}

void LeafList::Pad() {
  ++generation_;
  for (size_t i = size_; i < padded_size(); ++i) {
    for (auto& bound : bounds_) bound[i] = std::numeric_limits<float>::infinity();
  }
}

}  // namespace curvd
