#include "core/estimators/seams/seam_reach.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <variant>

#include "core/estimators/neighborhood_plan.h"

namespace curvd {
namespace {

using Normal = std::array<float, 3>;

float Dot(const Normal& a, const Normal& b) { return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]; }

float SquaredGap(const Box& a, const Box& b) {
  float squared[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float gap = std::max({a.lo[axis] - b.hi[axis], b.lo[axis] - a.hi[axis], 0.0f});
    squared[axis] = gap * gap;
  }
  return (squared[0] + squared[1]) + squared[2];
}

// Calls visit(leaf) for the leaves whose box is within a squared distance of `box`, until a visit returns true; returns
// whether one did, or more than `most_leaves` are so near.
template <typename Visit>
bool AnyLeaf(const SpatialIndex& index, const Box& box, float squared_reach, size_t most_leaves, Visit visit) {
  struct Pending {
    size_t node, first_leaf, leaves;
  };
  constexpr size_t kMaxDepth = 64;  // the tree is balanced over fewer than 2^31 leaves
  Pending stack[kMaxDepth] = {{0, 0, index.leaf_count()}};
  for (size_t depth = 1; depth > 0;) {
    const Pending top = stack[--depth];
    if (!(SquaredGap(index.node(top.node).box, box) <= squared_reach)) continue;
    if (top.leaves == 1) {
      if (most_leaves-- == 0 || visit(top.first_leaf)) return true;
      continue;
    }
    const size_t left = SpatialIndex::LeftLeaves(top.leaves);
    stack[depth++] = {SpatialIndex::RightChild(top.node, top.leaves), top.first_leaf + left, top.leaves - left};
    stack[depth++] = {top.node + 1, top.first_leaf, left};
  }
  return false;
}

using Query = SeamReach::Query;

// Calls visit(query) for each point of the group that gets a result.
template <typename Visit>
void ForEachQuery(const SpatialIndex& index, size_t group, Visit visit) {
  const size_t first = group * SpatialIndex::kGroupLeaves;
  const size_t last = std::min(first + SpatialIndex::kGroupLeaves, index.leaf_count());
  for (size_t leaf = first; leaf < last; ++leaf) {
    const SpatialIndex::LeafPositions& points = index.positions(leaf);
    const SpatialIndex::LeafNormals& normals = index.normals(leaf);
    for (int i = 0; i < index.LeafPoints(leaf); ++i) {
      if (!index.point_set().is_query(points.id[i])) continue;
      visit(Query{{points.x[i], points.y[i], points.z[i]},
                  {normals.x[i], normals.y[i], normals.z[i]},
                  leaf * SpatialIndex::kLeafSize + static_cast<size_t>(i),
                  index.point_set().slot_of(points.id[i])});
    }
  }
}

class GroupJudge {
 public:
  GroupJudge(const SpatialIndex& index, const SeamMarks& marks, size_t most_neighbors)
      : index_(index), marks_(marks), most_neighbors_(most_neighbors) {}

  // The square of a result's radius in the index's unit, rounded up.
  float SquaredReach(float radius) const {
    constexpr double kRoundingOfFloats = 1e-6;
    const double scaled = std::ldexp(double{radius}, index_.scale_exponent());
    const double squared = scaled * scaled * (1.0 + kRoundingOfFloats);
    return static_cast<float>(std::min<double>(squared, std::numeric_limits<float>::max()));
  }

  // Whether the leaf of a marked point is that near to the box; also where that takes too long to find out.
  bool IsNearMarks(const Box& box, float squared_reach) const {
    return AnyLeaf(index_, box, squared_reach, MostLeaves(), [&](size_t leaf) { return marks_.InLeaf(leaf) != 0; });
  }

  // Whether a marked point is that near to the query, and normals on the other side of its own or of the query's. True
  // also where so many points tie that it takes too long to find out.
  bool ReachesAcross(const Query& query, float squared_reach) const {
    Normal marked{};
    const bool has_marked = AnyMarked(query, squared_reach, [&](const Normal& normal) {
      marked = normal;
      return true;
    });
    if (!has_marked) return false;
    if (HasOtherSide({query.normal, marked}, query, squared_reach)) return true;
    // Of all marked points, those see the other side first that turn farthest from the ones before.
    std::array<Normal, 2> farthest = {marked, marked};
    AnyMarked(query, squared_reach, [&](const Normal& normal) {
      if (Dot(normal, query.normal) < Dot(farthest[0], query.normal)) farthest[0] = normal;
      if (Dot(normal, marked) < Dot(farthest[1], marked)) farthest[1] = normal;
      return false;
    });
    return HasOtherSide(farthest, query, squared_reach);
  }

 private:
  // So many times the points of a neighborhood may be as near as its last one, as on a lattice.
  static constexpr size_t kMostTied = 4;

  static bool IsNear(const SpatialIndex::LeafPositions& points, int i, const Box& box, float squared_reach) {
    const float position[3] = {points.x[i], points.y[i], points.z[i]};
    return SquaredDistance(position, box) <= squared_reach;
  }

  // Calls visit(normal) for the marked points that are that near to the query, until a visit returns true; returns
  // whether one did.
  template <typename Visit>
  bool AnyMarked(const Query& query, float squared_reach, Visit visit) const {
    const Box box{query.position, query.position};
    return AnyLeaf(index_, box, squared_reach, MostLeaves(), [&](size_t leaf) {
      const SpatialIndex::LeafNormals& normals = index_.normals(leaf);
      for (uint32_t bits = marks_.InLeaf(leaf); bits != 0; bits &= bits - 1) {
        const int i = std::countr_zero(bits);
        if (!IsNear(index_.positions(leaf), i, box, squared_reach)) continue;
        if (visit(Normal{normals.x[i], normals.y[i], normals.z[i]})) return true;
      }
      return false;
    });
  }

  // Whether the normal of a point that is that near to the query is more than a right angle from one of `sides`.
  bool HasOtherSide(const std::array<Normal, 2>& sides, const Query& query, float squared_reach) const {
    const Box box{query.position, query.position};
    size_t neighbors = 0;
    return AnyLeaf(index_, box, squared_reach, MostLeaves(), [&](size_t leaf) {
      const SpatialIndex::LeafNormals& normals = index_.normals(leaf);
      for (int i = 0; i < index_.LeafPoints(leaf); ++i) {
        if (!IsNear(index_.positions(leaf), i, box, squared_reach)) continue;
        if (++neighbors > kMostTied * most_neighbors_) return true;
        const Normal normal = {normals.x[i], normals.y[i], normals.z[i]};
        if (Dot(normal, sides[0]) < 0.0f || Dot(normal, sides[1]) < 0.0f) return true;
      }
      return false;
    });
  }

  // Leaves around a point or a group, where no more points tie than a neighborhood holds.
  size_t MostLeaves() const { return most_neighbors_ + 256; }

  const SpatialIndex& index_;
  const SeamMarks& marks_;
  const size_t most_neighbors_;
};

// Whether a marked point may be within the radius of a result of the group, or in the group.
bool IsGroupNearMarks(const GroupJudge& judge, const SpatialIndex& index, size_t group, const PointCurvature* results) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  float squared_reach = 0.0f;
  ForEachQuery(index, group, [&](const Query& query) {
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] = std::min(box.lo[axis], query.position[axis]);
      box.hi[axis] = std::max(box.hi[axis], query.position[axis]);
    }
    const PointCurvature& result = results[query.slot];
    if (result.status == PointStatus::kOk) squared_reach = std::max(squared_reach, judge.SquaredReach(result.radius));
  });
  return judge.IsNearMarks(box, squared_reach);
}

}  // namespace

SeamReach::SeamReach(const EstimatorOptions& options, const SpatialIndex& index, const SeamMarks& marks)
    : index_(index), marks_(marks), most_neighbors_(MostNeighbors(options, index.point_count())) {}

bool SeamReach::Reaches(const Query& query, float radius) const {
  const GroupJudge judge(index_, marks_, most_neighbors_);
  return judge.ReachesAcross(query, judge.SquaredReach(radius));
}

SeamReach::Group SeamReach::ReachingIn(size_t group, const PointCurvature* results) const {
  const bool is_near = IsGroupNearMarks(GroupJudge(index_, marks_, most_neighbors_), index_, group, results);
  Group found;
  ForEachQuery(index_, group, [&](const Query& query) {
    const PointCurvature& result = results[query.slot];
    found.slots[found.size] = query.slot;
    found.reaches[found.size++] =
        is_near && result.status == PointStatus::kOk && !marks_.IsMarked(query.place) && Reaches(query, result.radius);
  });
  return found;
}

void RefuseAtSeams(const EstimatorOptions& options, const SpatialIndex& index, const SeamMarks& marks, size_t group,
                   PointCurvature* results, RefusedCounts& refused) {
  const GroupJudge judge(index, marks, MostNeighbors(options, index.point_count()));
  if (!IsGroupNearMarks(judge, index, group, results)) return;
  ForEachQuery(index, group, [&](const Query& query) {
    PointCurvature& result = results[query.slot];
    const bool is_ok = result.status == PointStatus::kOk;
    const bool is_refused = marks.IsMarked(query.place)
                                ? is_ok || result.status == PointStatus::kInconsistentNormals
                                : is_ok && judge.ReachesAcross(query, judge.SquaredReach(result.radius));
    if (!is_refused) return;
    ++refused[static_cast<size_t>(result.status)];
    const float radius = result.radius;
    result = UndefinedCurvature(PointStatus::kOpposedNormals);
    result.radius = radius;
  });
}

}  // namespace curvd
