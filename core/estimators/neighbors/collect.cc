#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/neighbors/collect.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/group_estimate-inl.h"
#include "core/estimators/neighbors/collect.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Collects the neighbors of a query as NeighborCollector does, and their ids.
class NumberedCollector {
 public:
  NumberedCollector(const SpatialIndex& index, const QueryPoint& query, CollectedNormals normals, CollectScratch& s,
                    NormalSums& sums)
      : index_(&index),
        scratch_(&s),
        neighbors_(index, query, s.neighbors, sums,
                   normals == CollectedNormals::kOfHalves && index.has_half_normals()) {}

  HWY_INLINE void Start(size_t count) {
    neighbors_.Start(count);
    scratch_->ids.Reserve(count + NeighborArrays::kPad);
    count_ = 0;
  }
  HWY_INLINE void operator()(const NearPoints& near, FloatMask inside) {
    const IntTag d;
    neighbors_(near, inside);
    const auto ids = hn::Load(d, index_->positions(near.leaf).id + near.place);
    hn::StoreU(hn::Compress(ids, hn::RebindMask(d, inside)), d, scratch_->ids.data() + count_);
    count_ += hn::CountTrue(FloatTag(), inside);
  }
  HWY_INLINE void Finish() { neighbors_.Finish(); }

 private:
  const SpatialIndex* index_;
  CollectScratch* scratch_;
  NeighborCollector neighbors_;
  size_t count_ = 0;
};

absl::Status CollectEachKernel(const SpatialIndex& index, const NeighborhoodPlan& plan, size_t group,
                               CollectedPoints which, CollectedNormals normals, CollectScratch& s,
                               absl::FunctionRef<bool(size_t)> keep, absl::FunctionRef<void(size_t)> visit) {
  if (which == CollectedPoints::kAll) {
    LoadGroup<true>(index, group, s.points, s.first_point);
  } else {
    LoadGroup(index, group, s.points, s.first_point);
  }
  KeepPoints(keep, s.points);
  QueryPoint query;
  NormalSums sums;
  const NumberedCollector collector(index, query, normals, s, sums);
  return ForEachNeighborhood(index, plan, query, sums, collector, s, [&](size_t i, const LeafList&) { visit(i); });
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace curvd {

HWY_EXPORT(CollectEachKernel);

absl::Status CollectNeighbors(const SpatialIndex& index, const NeighborhoodPlan& plan, size_t group,
                              CollectedPoints which, CollectedNormals normals, CollectScratch& scratch,
                              absl::FunctionRef<bool(size_t i)> keep, absl::FunctionRef<void(size_t i)> visit) {
  return HWY_DYNAMIC_DISPATCH(CollectEachKernel)(index, plan, group, which, normals, scratch, keep, visit);
}

}  // namespace curvd

#endif  // HWY_ONCE
