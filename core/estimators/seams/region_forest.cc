#include "core/estimators/seams/region_forest.h"

#include <algorithm>
#include <utility>

namespace curvd {

absl::StatusOr<RegionForest> RegionForest::Create(size_t point_count) {
  auto parents = PageArray<int32_t>::Create(point_count);
  if (!parents.ok()) return parents.status();
  RegionForest forest;
  forest.parents_ = *std::move(parents);
  std::fill(forest.parents_.data(), forest.parents_.data() + point_count, -1);
  return forest;
}

// Nothing but the parents passes between threads, so that no order of other memory matters.
size_t RegionForest::RootOf(size_t point) {
  for (;;) {
    const int32_t parent = ParentOf(point).load(std::memory_order_relaxed);
    if (parent < 0) return point;
    const int32_t grandparent = ParentOf(static_cast<size_t>(parent)).load(std::memory_order_relaxed);
    if (grandparent < 0) return static_cast<size_t>(parent);
    // Halves the path for those who come later. Another thread may have come further: that is no harm.
    ParentOf(point).store(grandparent, std::memory_order_relaxed);
    point = static_cast<size_t>(grandparent);
  }
}

bool RegionForest::Join(size_t a, size_t b) {
  for (;;) {
    a = RootOf(a), b = RootOf(b);
    if (a == b) return false;
    if (a < b) std::swap(a, b);
    // Fails where another thread has joined `a` meanwhile.
    int32_t size = ParentOf(a).load(std::memory_order_relaxed);
    if (size < 0 && ParentOf(a).compare_exchange_strong(size, static_cast<int32_t>(b), std::memory_order_relaxed)) {
      return true;
    }
  }
}

void RegionForest::Measure(size_t point) {
  const size_t root = RootOf(point);
  if (root != point) ParentOf(root).fetch_sub(1, std::memory_order_relaxed);
}

size_t RegionForest::MeasuredSize(size_t point) {
  return static_cast<size_t>(-int64_t{ParentOf(RootOf(point)).load(std::memory_order_relaxed)});
}

}  // namespace curvd
