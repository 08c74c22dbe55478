#include "core/scale/outliers/nearest_points.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/scale/outliers/nearest_points.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/group_estimate-inl.h"
#include "core/search/group_search-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Lists the neighbors of a query, the query itself among them, in tree order.
class PlaceLister {
 public:
  PlaceLister(NearestScratch& out, size_t& count) : out_(&out), all_(&count) {}

  HWY_INLINE void Start(size_t) { count_ = 0; }
  HWY_INLINE void operator()(const NearPoints& near, FloatMask inside) {
    const FloatTag d;
    const IntTag di;
    const auto first = static_cast<int32_t>(size_t{near.leaf} * SpatialIndex::kLeafSize + near.place);
    hn::StoreU(hn::Compress(near.squared, inside), d, out_->squared_distances + count_);
    hn::StoreU(hn::Compress(hn::Iota(di, first), hn::RebindMask(di, inside)), di, out_->places + count_);
    count_ += hn::CountTrue(d, inside);
  }
  HWY_INLINE void Finish() { *all_ = count_; }

 private:
  NearestScratch* out_;
  size_t* all_;
  size_t count_ = 0;
};

absl::Status ListNearest(const SpatialIndex& index, size_t group, NearestScratch& s,
                         absl::FunctionRef<void(size_t i, size_t count)> visit) {
  LoadGroup(index, group, s.points, s.first_point);
  if (s.points.size == 0) return absl::OkStatus();
  const uint64_t began = s.search.work;
  s.search.stopped = s.stopped;
  const SearchPlan plan = SearchPlan::ByCount(std::min(NearestScratch::kNearest + 1, index.point_count()));
  GroupSearch search(index, plan, s.points.box, s.search);
  size_t count = 0;
  for (size_t i = 0; i < s.points.size; ++i) {
    float query[3];
    s.points.query.Get(i, query);
    search.Find(query, PlaceLister(s, count));
    if (s.IsStopped()) return Stopped();
    visit(i, count);
    if (s.search.work - began > s.most_work && i + 1 < s.points.size) {
      s.rest = s.first_point + i + 1;
      break;
    }
  }
  search.PassOn();
  return absl::OkStatus();
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace curvd {

HWY_EXPORT(ListNearest);

absl::Status ForEachNearest(const SpatialIndex& index, size_t group, NearestScratch& scratch,
                            absl::FunctionRef<void(size_t i, std::span<const NearestPoint> neighbors)> visit) {
  const auto sort = [&](size_t i, size_t count) {
    size_t others = 0;
    for (size_t j = 0; j < count; ++j) {
      if (scratch.places[j] == scratch.points.place[i]) continue;
      scratch.neighbors[others++] = {scratch.squared_distances[j], static_cast<uint32_t>(scratch.places[j])};
    }
    const std::span<NearestPoint> neighbors(scratch.neighbors, others);
    std::sort(neighbors.begin(), neighbors.end(), [](const NearestPoint& a, const NearestPoint& b) {
      return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance : a.place < b.place;
    });
    visit(i, neighbors);
  };
  return HWY_DYNAMIC_DISPATCH(ListNearest)(index, group, scratch, sort);
}

}  // namespace curvd

#endif  // HWY_ONCE
