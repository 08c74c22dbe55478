// Collects the neighbors of a query, and the order in which random strategies number them: that of their ranks, which is
// the same for a cloud and its parts.

#if defined(CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_
#undef CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_
#endif

#include <algorithm>
#include <limits>

#include "core/estimators/neighbors-inl.h"
#include "core/estimators/triangles/triangle_scratch.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Sets order[i] to the place of the i-th lowest of `count` distinct numbers, after which kPad larger ones follow.
HWY_INLINE void OrderByCounting(const int32_t* numbers, size_t count, uint32_t* order) {
  const IntTag d;
  for (size_t i = 0; i < count; ++i) {
    const auto own = hn::Set(d, numbers[i]);
    size_t lower = 0;
    for (size_t j = 0; j < count; j += hn::Lanes(d)) lower += hn::CountTrue(d, hn::Lt(hn::Load(d, numbers + j), own));
    order[lower] = static_cast<uint32_t>(i);
  }
}

// A visitor of GroupSearch: as NeighborCollector, and sets s.order.
class RankedCollector {
 public:
  RankedCollector(const SpatialIndex& index, const QueryPoint& query, TriangleScratch& s, NormalSums& sums)
      : index_(&index), scratch_(&s), neighbors_(index, query, s.neighbors, sums) {}

  HWY_INLINE void Start(size_t count) {
    neighbors_.Start(count);
    scratch_->ranks.Reserve(count + NeighborArrays::kPad);
    scratch_->order.Reserve(count);
    count_ = 0;
  }
  HWY_INLINE void operator()(const NearPoints& near, FloatMask inside) {
    const IntTag d;
    neighbors_(near, inside);
    const auto ranks = hn::Load(d, index_->positions(near.leaf).id + near.place);
    hn::StoreU(hn::Compress(ranks, hn::RebindMask(d, inside)), d, scratch_->ranks.data() + count_);
    count_ += hn::CountTrue(FloatTag(), inside);
  }
  HWY_INLINE void Finish() {
    constexpr size_t kFew = 128;  // a sort is faster above
    neighbors_.Finish();
    int32_t* const ranks = scratch_->ranks.data();
    uint32_t* const order = scratch_->order.data();
    std::fill_n(ranks + count_, NeighborArrays::kPad, std::numeric_limits<int32_t>::max());
    if (count_ <= kFew) return OrderByCounting(ranks, count_, order);
    for (size_t i = 0; i < count_; ++i) order[i] = static_cast<uint32_t>(i);
    std::sort(order, order + count_, [ranks](uint32_t a, uint32_t b) { return ranks[a] < ranks[b]; });
  }

 private:
  const SpatialIndex* index_;
  TriangleScratch* scratch_;
  NeighborCollector neighbors_;
  size_t count_ = 0;
};

// ForEachCollected with that collector.
template <typename Visit>
HWY_INLINE absl::Status ForEachRanked(const SpatialIndex& index, const NeighborhoodPlan& plan, TriangleScratch& s,
                                      Visit visit) {
  QueryPoint query;
  NormalSums normals;
  const RankedCollector collector(index, query, s, normals);
  return ForEachNeighborhood(index, plan, query, normals, collector, s, visit);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_
