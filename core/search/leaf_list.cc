#include "core/search/leaf_list.h"

#include <limits>

namespace curvd {

void LeafList::Grow(size_t size) {
  leaves_.Reserve(size + kPad);
  for (auto& bound : bounds_) bound.Reserve(size + kPad);
}

void LeafList::Pad() {
  ++generation_;
  for (size_t i = size_; i < padded_size(); ++i) {
    for (auto& bound : bounds_) bound[i] = std::numeric_limits<float>::infinity();
  }
}

}  // namespace curvd
