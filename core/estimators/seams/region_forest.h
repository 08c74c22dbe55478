// Points of a cloud that many threads join into regions.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "absl/status/statusor.h"
#include "core/base/page_array.h"

namespace curvd {

// Points are numbers below point_count; at first each is a region of its own. In whatever order the same pairs are
// joined, the regions are the same in the end, and so is the number of joins that made one region of two (union-find: a
// forest in which each point refers to one with a lower number, the lowest of its region to none).
// Thread-safe, save for moves.
class RegionForest {
 public:
  RegionForest() = default;
  // REQUIRES: point_count < 2^31.
  // Errors: ErrorKind::kOutOfMemory, the system gave no memory.
  static absl::StatusOr<RegionForest> Create(size_t point_count);

  // Makes one region of those of two points. Returns false if they were one already.
  bool Join(size_t a, size_t b);

  // Counts a point in the size of its region. REQUIRES: called once for each point, after all joins whose regions are
  // to be measured.
  void Measure(size_t point);
  // How many points a region had when it was measured; of a region that was joined since, the size of one of its parts.
  size_t MeasuredSize(size_t point);

  size_t bytes() const { return parents_.bytes(); }

 private:
  std::atomic_ref<int32_t> ParentOf(size_t point) { return std::atomic_ref<int32_t>(parents_[point]); }
  size_t RootOf(size_t point);

  // Of a root: -1 less the other points that were measured.
  PageArray<int32_t> parents_;
};

}  // namespace curvd
