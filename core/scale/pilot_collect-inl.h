// Collects the neighbors of the sampled points of a group.

#if defined(CURVD_CORE_SCALE_PILOT_COLLECT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_SCALE_PILOT_COLLECT_INL_H_
#undef CURVD_CORE_SCALE_PILOT_COLLECT_INL_H_
#else
#define CURVD_CORE_SCALE_PILOT_COLLECT_INL_H_
#endif

#include "core/estimators/group_estimate-inl.h"
#include "core/scale/pilot.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Collects the neighbors of a query as NeighborCollector does, and their ids.
class NumberedCollector {
 public:
  NumberedCollector(const SpatialIndex& index, const QueryPoint& query, PilotScratch& s, NormalSums& sums)
      : index_(&index), scratch_(&s), neighbors_(index, query, s.neighbors, sums) {}

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
  PilotScratch* scratch_;
  NeighborCollector neighbors_;
  size_t count_ = 0;
};

// Leaves the first point of each leaf that is sampled.
inline void KeepSampled(const Pilot& pilot, GroupPoints& points) {
  int32_t last_leaf = -1;
  const auto is_first_sampled = [&](size_t i) {
    const int32_t leaf = points.place[i] / SpatialIndex::kLeafSize;
    if (leaf == last_leaf || !pilot.IsSampled(static_cast<size_t>(leaf))) return false;
    last_leaf = leaf;
    return true;
  };
  KeepPoints(is_first_sampled, points);
}

inline absl::Status CollectKernel(const Pilot& pilot, size_t group, PilotScratch& s, PilotTable& table) {
  const SpatialIndex& index = pilot.index();
  LoadGroup(index, group, s.points);
  KeepSampled(pilot, s.points);
  QueryPoint query;
  NormalSums normals;
  const NumberedCollector collector(index, query, s, normals);
  return ForEachNeighborhood(index, pilot.plan(), query, normals, collector, s, [&](size_t i, const LeafList&) {
    float position[3];
    s.points.query.Get(i, position);
    PilotPoint& point = table[pilot.SampleFrom(static_cast<size_t>(s.points.place[i]) / SpatialIndex::kLeafSize)];
    point = PilotPoint({position[0], position[1], position[2]});
    EstimateRungs(pilot.rung_count(), s, point);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_SCALE_PILOT_COLLECT_INL_H_
