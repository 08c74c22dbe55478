// One group's way through the kernels.

#if defined(CURVD_CORE_ESTIMATORS_GROUP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_GROUP_INL_H_
#undef CURVD_CORE_ESTIMATORS_GROUP_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_GROUP_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "core/estimators/delaunay/umbrella_triangles-inl.h"
#include "core/estimators/fits/algebraic_sphere-inl.h"
#include "core/estimators/fits/jet-inl.h"
#include "core/estimators/fits/sphere_field-inl.h"
#include "core/estimators/frames-inl.h"
#include "core/estimators/group_buffers.h"
#include "core/estimators/hexagram/hexagram-inl.h"
#include "core/estimators/hexagram/nearest_corners-inl.h"
#include "core/estimators/hexagram/sector_sums-inl.h"
#include "core/estimators/principal-inl.h"
#include "core/estimators/random_triangles-inl.h"
#include "core/search/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Loads the queries of a group, or all of its points; returns their box.
template <bool kAllPoints = false>
HWY_INLINE Box LoadGroup(const SpatialIndex& index, size_t group, GroupScratch::Buffers& b) {
  const PointSet& set = index.point_set();
  b.size = 0;
  const size_t first = group * SpatialIndex::kGroupLeaves;
  const size_t last = std::min(first + SpatialIndex::kGroupLeaves, index.leaf_count());
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (size_t leaf = first; leaf < last; ++leaf) {
    const SpatialIndex::LeafPositions& points = index.positions(leaf);
    const SpatialIndex::LeafNormals& normals = index.normals(leaf);
    const int count = index.LeafPoints(leaf);
    for (int i = 0; i < count; ++i) {
      if (!kAllPoints && !set.is_query(points.id[i])) continue;
      const float position[3] = {points.x[i], points.y[i], points.z[i]};
      const float normal[3] = {normals.x[i], normals.y[i], normals.z[i]};
      for (int axis = 0; axis < 3; ++axis) {
        box.lo[axis] = std::min(box.lo[axis], position[axis]);
        box.hi[axis] = std::max(box.hi[axis], position[axis]);
      }
      b.query.Set(b.size, position);
      b.normal.Set(b.size, normal);
      b.id[b.size] = points.id[i];
      b.seed[b.size] = set.seed_of(points.id[i]);
      b.slot[b.size++] = set.slot_of(points.id[i]);
    }
  }
  return box;
}

// Finds neighborhoods of the points of one group, sharing one list of leaves as long as that pays.
template <Wanted kWanted>
class GroupSearch {
 public:
  GroupSearch(const SpatialIndex& index, const EstimationPlan& plan, const Box& box, GroupScratch::Buffers& b)
      : index_(index), plan_(plan), box_(box), b_(b) {
    if (plan.by_radius) {
      squared_reach_ = plan.squared_radius;
      listed_ = GatherLeaves(index_, box_, squared_reach_, MaxListedLeaves(plan.max_neighbor_count), b_.leaves);
    } else {
      StartReach();
    }
  }

  // Sets the neighbors of point i; returns their largest squared distance.
  HWY_INLINE float Find(size_t i) { return plan_.by_radius ? FindInRadius(i) : FindNearestPoints(i); }

  // The leaves that were searched last.
  const LeafList& leaves() const { return listed_ ? b_.leaves : b_.own_leaves; }

  // The largest neighborhood of the group, from which the next group starts.
  float largest_squared_radius() const { return largest_; }

 private:
  // Beyond this a list costs more to cull than a descent of the tree.
  static size_t MaxListedLeaves(size_t neighbors) { return neighbors / 2 + 192; }

  bool List(float squared_reach) {
    squared_reach_ = squared_reach;
    return listed_ = GatherLeaves(index_, box_, squared_reach, MaxListedLeaves(plan_.searched_count), b_.leaves);
  }

  void StartReach() {
    constexpr int kMaxHalvings = 12;
    float diagonal = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      const float extent = box_.hi[axis] - box_.lo[axis];
      diagonal += extent * extent;
    }
    // 1.2 times the last group's: the density of a scan changes slowly.
    float squared_reach = b_.reach_hint > 0.0f ? b_.reach_hint * 1.44f : diagonal;
    for (int i = 0; i < kMaxHalvings && !List(squared_reach); ++i) squared_reach *= 0.25f;
  }

  HWY_NOINLINE float FindNearestPoints(size_t i) {
    const size_t k = plan_.searched_count;
    const float query[3] = {b_.query.x[i], b_.query.y[i], b_.query.z[i]};
    while (listed_) {
      const float guess = last_ > 0.0f ? last_ * kGuessGrowth : squared_reach_;
      const float found = NearestInReach<kWanted>(index_, b_.leaves, query, k, guess, squared_reach_, b_);
      if (found >= 0.0f) return Record(found);
      if (squared_reach_ <= 0.0f || squared_reach_ > kWholeIndex)
        listed_ = false;
      else
        List(squared_reach_ * 2.0f);
    }
    return Record(NearestByDescent<kWanted>(index_, query, k, b_));
  }

  HWY_NOINLINE float FindInRadius(size_t i) {
    const float query[3] = {b_.query.x[i], b_.query.y[i], b_.query.z[i]};
    const Box point{{query[0], query[1], query[2]}, {query[0], query[1], query[2]}};
    if (!listed_) GatherLeaves(index_, point, squared_reach_, index_.leaf_count(), b_.own_leaves);
    const LeafList& leaves = listed_ ? b_.leaves : b_.own_leaves;
    const size_t near_count = CullLeaves(leaves, query, squared_reach_, b_);
    const size_t count = MeasureDistances(index_, query, squared_reach_, near_count, b_);
    return Collect<kWanted>(index_, query, {squared_reach_}, count, near_count, b_);
  }

  float Record(float squared_radius) {
    last_ = squared_radius;
    largest_ = std::max(largest_, squared_radius);
    return squared_radius;
  }

  // The squared radius of the last neighborhood grown by this holds the next one 9 times out of 10.
  static constexpr float kGuessGrowth = 1.16f;
  static constexpr float kWholeIndex = 16.0f;  // no two points are farther apart: the index's extent is below 1

  const SpatialIndex& index_;
  const EstimationPlan& plan_;
  const Box& box_;
  GroupScratch::Buffers& b_;
  float squared_reach_ = 0.0f;
  float last_ = 0.0f;
  float largest_ = 0.0f;
  bool listed_ = false;
};

// Searches the neighborhood of each point of the group, records it, and calls `visit(i, leaves)` with the leaves that
// were searched. Stops at the first that is too large.
template <Wanted kWanted, typename Visit>
HWY_INLINE OversizedNeighborhood ForEachNeighborhood(const SpatialIndex& index, const EstimationPlan& plan,
                                                     const Box& box, GroupScratch::Buffers& b, Visit visit) {
  GroupSearch<kWanted> search(index, plan, box, b);
  for (size_t i = 0; i < b.size; ++i) {
    b.squared_radius[i] = search.Find(i);
    if (b.neighbors.count > plan.max_neighbor_count) return {b.id[i]};
    b.neighbor_count[i] = static_cast<float>(b.neighbors.count);
    b.normal_sum.Set(i, b.neighbors.normal_sum);
    visit(i, search.leaves());
  }
  b.reach_hint = search.largest_squared_radius();
  return {};
}

// The same for estimators that work neighborhood by neighborhood: calls `estimate(i, leaves)` for points that have one.
template <Wanted kWanted, typename Estimate>
HWY_INLINE OversizedNeighborhood EstimateEach(const SpatialIndex& index, const EstimationPlan& plan, const Box& box,
                                              GroupScratch::Buffers& b, Estimate estimate) {
  return ForEachNeighborhood<kWanted>(index, plan, box, b, [&](size_t i, const LeafList& leaves) {
    PreparePoints(OnePoint(), plan, b, i);
    if (b.status[i] == PointStatus::kOk) estimate(i, leaves);
  });
}

// The hexagram of nearest points: all neighborhoods first, then all corners.
HWY_INLINE OversizedNeighborhood FindHexagrams(const SpatialIndex& index, const EstimationPlan& plan, const Box& box,
                                               GroupScratch::Buffers& b) {
  const FloatTag d;
  const OversizedNeighborhood oversized =
      ForEachNeighborhood<Wanted::kNormalSum>(index, plan, box, b, [](size_t, const LeafList&) {});
  if (oversized.point_id >= 0) return oversized;
  for (size_t i = 0; i < b.size; i += hn::Lanes(d)) PreparePoints(d, plan, b, i);
  CornerSearch(index, b).SetCorners();
  return {};
}

// Finds neighborhoods of single points of a group once more.
class RepeatedSearch {
 public:
  RepeatedSearch(const SpatialIndex& index, const EstimationPlan& plan, const Box& box, GroupScratch::Buffers& b)
      : index_(index), plan_(plan), box_(box), b_(b) {}

  HWY_NOINLINE void operator()(size_t i) {
    if (!search_.has_value()) search_.emplace(index_, plan_, box_, b_);
    search_->Find(i);
  }

 private:
  const SpatialIndex& index_;
  const EstimationPlan& plan_;
  const Box& box_;
  GroupScratch::Buffers& b_;
  std::optional<GroupSearch<Wanted::kNeighbors>> search_;
};

inline OversizedNeighborhood EstimateGroupKernel(const SpatialIndex& index, const EstimationPlan& plan, size_t group,
                                                 GroupScratch& scratch, PointCurvature* out) {
  GroupScratch::Buffers& b = scratch.buffers();
  const Box box = LoadGroup(index, group, b);
  // The field is in another order; it is written when all are done.
  for (size_t i = 0; i < b.size; ++i) __builtin_prefetch(&out[b.slot[i]], 1);
  if (b.size == 0) return {};
  for (size_t i = b.size; i < SpatialIndex::kGroupPoints; ++i) FillPoint(b, i);
  if (FitsSurface(plan.estimator) && b.fits == nullptr) b.fits = std::make_unique<FitBuffers>();
  OversizedNeighborhood oversized;
  if (plan.estimator == EstimatorKind::kHexagram) {
    oversized = FindHexagrams(index, plan, box, b);
  } else if (plan.estimator == EstimatorKind::kDelaunay) {
    oversized = EstimateEach<Wanted::kNormalSum>(
        index, plan, box, b, [&](size_t i, const LeafList& leaves) { MeasureUmbrellas(index, plan, leaves, b, i); });
  } else if (plan.estimator == EstimatorKind::kAvgHexagram) {
    oversized = EstimateEach<Wanted::kNormalSum>(
        index, plan, box, b, [&](size_t i, const LeafList& leaves) { SumHexagrams(index, plan, leaves, b, i); });
  } else {
    oversized = EstimateEach<Wanted::kNeighbors>(index, plan, box, b, [&](size_t i, const LeafList&) {
      if (plan.estimator == EstimatorKind::kUniform) {
        MeasureUniform(plan, b, i);
      } else if (plan.estimator == EstimatorKind::kIndependent) {
        MeasureIndependent(plan, b, i);
      } else if (plan.estimator == EstimatorKind::kJetFitting) {
        SumJet(plan, b, i);
      } else if (plan.estimator == EstimatorKind::kAlgebraicShapeOperator) {
        SumSphere(b, i);
      }
    });
  }
  if (oversized.point_id >= 0) return oversized;
  if (plan.estimator == EstimatorKind::kAvgHexagram || plan.estimator == EstimatorKind::kHexagram) {
    MeasureHexagrams(plan.rotations, b);
  }
  GroupCurvature curvature;
  if (plan.estimator == EstimatorKind::kJetFitting) {
    SolveJets(plan, b, RepeatedSearch(index, plan, box, b));
    TakeShapes(b, curvature);
  } else if (plan.estimator == EstimatorKind::kAlgebraicShapeOperator) {
    SolveSpheres(b);
    TakeShapes(b, curvature);
  } else {
    ComputeCurvature(b, curvature);
    RefuseThinAreas(b);
  }
  ScaleCurvature(plan, b, curvature);
  WriteGroup(plan, curvature, b, out);
  return {};
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_GROUP_INL_H_
