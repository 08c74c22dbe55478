#include "core/scale/outliers/nearest_points.h"

#include <algorithm>
#include <span>

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

// Puts the listed neighbors of point i in ascending order, those at one distance by place, and leaves the point itself
// out. Each goes where the number of those before it says, which takes no branches.
std::span<const NearestPoint> InOrder(size_t i, size_t count, NearestScratch& s) {
  const FloatTag d;
  const IntTag di;
  for (size_t j = 0; j < count; ++j) {
    if (s.places[j] == s.points.place[i]) s.squared_distances[j] = -1.0f;
  }
  for (size_t j = 0; j < count; j += hn::Lanes(d)) {
    const FloatVec own = hn::LoadU(d, s.squared_distances + j);
    const auto own_place = hn::LoadU(di, s.places + j);
    auto before = hn::Zero(di);
    for (size_t other = 0; other < count; ++other) {
      const FloatVec others = hn::Set(d, s.squared_distances[other]);
      const auto has_earlier_place = hn::RebindMask(d, hn::Lt(hn::Set(di, s.places[other]), own_place));
      const FloatMask is_before = hn::Or(hn::Lt(others, own), hn::And(hn::Eq(others, own), has_earlier_place));
      before = hn::Sub(before, hn::VecFromMask(di, hn::RebindMask(di, is_before)));
    }
    hn::StoreU(before, di, s.order + j);
  }
  for (size_t j = 0; j < count; ++j) {
    s.neighbors[s.order[j]] = {s.squared_distances[j], static_cast<uint32_t>(s.places[j])};
  }
  const bool is_listed = count > 0 && s.neighbors[0].squared_distance < 0.0f;
  return std::span<const NearestPoint>(s.neighbors, count).subspan(is_listed ? 1 : 0);
}

absl::Status ListNearest(const SpatialIndex& index, size_t group, size_t nearest, NearestScratch& s,
                         absl::FunctionRef<bool(size_t place)> is_wanted,
                         absl::FunctionRef<void(size_t i, std::span<const NearestPoint> neighbors)> visit) {
  LoadGroup(index, group, s.points, s.first_point);
  if (s.points.size == 0) return absl::OkStatus();
  const uint64_t began = s.search.work;
  s.search.stopped = s.stopped;
  const SearchPlan plan = SearchPlan::ByCount(std::min(nearest + 1, index.point_count()));
  GroupSearch search(index, plan, s.points.box, s.search);
  size_t count = 0;
  for (size_t i = 0; i < s.points.size; ++i) {
    if (!is_wanted(static_cast<size_t>(s.points.place[i]))) continue;
    float query[3];
    s.points.query.Get(i, query);
    search.Find(query, PlaceLister(s, count));
    if (s.IsStopped()) return Stopped();
    visit(i, InOrder(i, count, s));
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

absl::Status ForEachNearest(const SpatialIndex& index, size_t group, size_t nearest, NearestScratch& scratch,
                            absl::FunctionRef<bool(size_t place)> is_wanted,
                            absl::FunctionRef<void(size_t i, std::span<const NearestPoint> neighbors)> visit) {
  return HWY_DYNAMIC_DISPATCH(ListNearest)(index, group, nearest, scratch, is_wanted, visit);
}

}  // namespace curvd

#endif  // HWY_ONCE
