// Takes back the status of points whose neighbors lie along a line (core/estimators/lines/line_test.h).

#if defined(CURVD_CORE_ESTIMATORS_LINES_REFUSE_LINES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_LINES_REFUSE_LINES_INL_H_
#undef CURVD_CORE_ESTIMATORS_LINES_REFUSE_LINES_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_LINES_REFUSE_LINES_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/estimators/group_scratch.h"
#include "core/estimators/lines/line_test.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/search/group_search-inl.h"
#include "core/search/neighbor_offsets.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// A visitor of GroupSearch: collects the offsets of the neighbors from the query.
class LineCollector {
 public:
  LineCollector(const SpatialIndex& index, const float* query, NeighborOffsets& offsets)
      : index_(&index), query_(query), offsets_(&offsets) {}

  HWY_INLINE void Start(size_t count) {
    offsets_->Reserve(count);
    count_ = 0;
  }
  HWY_INLINE void operator()(const NearPoints& near, FloatMask inside) {
    const FloatTag d;
    const SpatialIndex::LeafPositions& points = index_->positions(near.leaf);
    const QueryVectors q(query_);
    const size_t i = near.place;
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.x + i), q.x), inside), d, offsets_->x.data() + count_);
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.y + i), q.y), inside), d, offsets_->y.data() + count_);
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.z + i), q.z), inside), d, offsets_->z.data() + count_);
    count_ += hn::CountTrue(d, inside);
  }
  HWY_INLINE void Finish() { offsets_->count = count_; }

 private:
  const SpatialIndex* index_;
  const float* query_;
  NeighborOffsets* offsets_;
  size_t count_ = 0;
};

// Finds the neighbors of single points of a group once more, as search.offsets.
class OffsetSearch {
 public:
  OffsetSearch(const SpatialIndex& index, const NeighborhoodPlan& plan, const GroupPoints& points,
               SearchScratch& search)
      : index_(index), plan_(plan), points_(points), scratch_(search) {}

  // Returns the neighborhood's radius, in the index's unit. What is found is worth nothing once the scratch is stopped.
  HWY_NOINLINE float Find(size_t i) {
    if (!search_.has_value()) search_.emplace(index_, plan_.search, points_.box, scratch_);
    float query[3];
    points_.query.Get(i, query);
    const float squared = search_->Find(query, LineCollector(index_, query, scratch_.offsets));
    // The sums over them, some in scalar code.
    scratch_.work += 8 * scratch_.offsets.count;
    return std::sqrt(squared);
  }

 private:
  const SpatialIndex& index_;
  const NeighborhoodPlan& plan_;
  const GroupPoints& points_;
  SearchScratch& scratch_;
  std::optional<GroupSearch> search_;
};

// The normal of the tangent frame of point i.
HWY_INLINE void FrameNormal(const GroupFrames& frames, size_t i, float* normal) {
  float u[3], v[3];
  frames.u.Get(i, u);
  frames.v.Get(i, v);
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    normal[a] = u[b] * v[c] - u[c] * v[b];
  }
}

// Gives `status` to the points that lie along a line, of those that are OK and of which `may_be_line(i)` says that they
// may. `normal_of(i, normal)` sets the normal of point i. `fades` as in MeasureLine. `searching` is the scratch whose
// searches are used: `s` itself, or that of the largest of several scales.
template <typename MayBeLine, typename NormalOf>
HWY_INLINE void RefuseLines(const SpatialIndex& index, const NeighborhoodPlan& plan, bool fades, PointStatus status,
                            MayBeLine may_be_line, NormalOf normal_of, GroupScratch& searching, GroupScratch& s) {
  OffsetSearch search(index, plan, s.points, searching.search);
  for (size_t i = 0; i < s.points.size && !searching.IsStopped(); ++i) {
    if (HWY_LIKELY(s.points.status[i] != PointStatus::kOk || !may_be_line(i))) continue;
    const float radius = search.Find(i);
    float normal[3];
    normal_of(i, normal);
    if (MeasureLine(searching.search.offsets, normal, radius, fades).IsLine()) s.points.status[i] = status;
  }
}

// The same with the normals of the points' frames.
template <typename MayBeLine>
HWY_INLINE void RefuseLines(const SpatialIndex& index, const NeighborhoodPlan& plan, bool fades, PointStatus status,
                            MayBeLine may_be_line, GroupScratch& searching, GroupScratch& s) {
  const auto of_frame = [&s](size_t i, float* normal) { FrameNormal(s.frames, i, normal); };
  RefuseLines(index, plan, fades, status, may_be_line, of_frame, searching, s);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_LINES_REFUSE_LINES_INL_H_
