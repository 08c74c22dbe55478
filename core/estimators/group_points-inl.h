// Loads the points of a group from the index.

#if defined(CURVD_CORE_ESTIMATORS_GROUP_POINTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_GROUP_POINTS_INL_H_
#undef CURVD_CORE_ESTIMATORS_GROUP_POINTS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_GROUP_POINTS_INL_H_
#endif

#include <algorithm>
#include <limits>

#include "core/estimators/group_points.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Loads the points of a group that get results; with kAllPoints also those that are neighbors alone, whose `slot` is
// GroupPoints::kNoSlot. Leaves out the first `skipped` of them.
template <bool kAllPoints = false>
HWY_INLINE void LoadGroup(const SpatialIndex& index, size_t group, GroupPoints& out, size_t skipped = 0) {
  const PointSet& set = index.point_set();
  out.size = 0;
  const size_t first = group * SpatialIndex::kGroupLeaves;
  const size_t last = std::min(first + SpatialIndex::kGroupLeaves, index.leaf_count());
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  out.box = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (size_t leaf = first; leaf < last; ++leaf) {
    const SpatialIndex::LeafPositions& points = index.positions(leaf);
    for (int i = 0; i < index.LeafPoints(leaf); ++i) set.Prefetch(points.id[i]);
  }
  for (size_t leaf = first; leaf < last; ++leaf) {
    const SpatialIndex::LeafPositions& points = index.positions(leaf);
    const SpatialIndex::LeafNormals& normals = index.normals(leaf);
    const int count = index.LeafPoints(leaf);
    for (int i = 0; i < count; ++i) {
      const bool is_query = set.is_query(points.id[i]);
      if (!kAllPoints && !is_query) continue;
      if (skipped > 0) {
        --skipped;
        continue;
      }
      const float position[3] = {points.x[i], points.y[i], points.z[i]};
      const float normal[3] = {normals.x[i], normals.y[i], normals.z[i]};
      for (int axis = 0; axis < 3; ++axis) {
        out.box.lo[axis] = std::min(out.box.lo[axis], position[axis]);
        out.box.hi[axis] = std::max(out.box.hi[axis], position[axis]);
      }
      out.query.Set(out.size, position);
      out.normal.Set(out.size, normal);
      out.rank[out.size] = points.id[i];
      out.slot[out.size] = is_query ? set.slot_of(points.id[i]) : GroupPoints::kNoSlot;
      out.place[out.size++] = static_cast<int32_t>(leaf * SpatialIndex::kLeafSize) + i;
    }
  }
}

// Copies what LoadGroup has set of point `from` to place `to` of another group, or of the same.
inline void CopyPoint(const GroupPoints& points, size_t from, size_t to, GroupPoints& out) {
  float vector[3];
  points.query.Get(from, vector);
  out.query.Set(to, vector);
  points.normal.Get(from, vector);
  out.normal.Set(to, vector);
  out.rank[to] = points.rank[from];
  out.slot[to] = points.slot[from];
  out.place[to] = points.place[from];
}

// Leaves the points for whose index `keep` returns true; it is called once for each, in ascending order, before the
// point is moved.
template <typename Keep>
void KeepPoints(Keep keep, GroupPoints& points) {
  size_t kept = 0;
  for (size_t i = 0; i < points.size; ++i) {
    if (keep(i)) CopyPoint(points, i, kept++, points);
  }
  points.size = kept;
}

// Leaves the first point of each leaf.
inline void KeepFirstOfLeaves(GroupPoints& points) {
  KeepPoints([&points](size_t i) { return points.place[i] % SpatialIndex::kLeafSize == 0; }, points);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_GROUP_POINTS_INL_H_
