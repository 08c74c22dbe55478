// Lists the leaves of an index that may hold neighbors of a group of query points.

#if defined(CURVD_CORE_SEARCH_GATHER_LEAVES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_SEARCH_GATHER_LEAVES_INL_H_
#undef CURVD_CORE_SEARCH_GATHER_LEAVES_INL_H_
#else
#define CURVD_CORE_SEARCH_GATHER_LEAVES_INL_H_
#endif

#include <algorithm>

#include "core/index/vectors-inl.h"
#include "core/search/leaf_list.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Tells whether nodes, an axis a lane, or leaves, a leaf a lane, meet the reach around a box.
class ReachTest {
 public:
  ReachTest(const Box& box, float squared_reach) : squared_reach_(squared_reach) {
    std::copy(box.lo.begin(), box.lo.end(), lo_);
    std::copy(box.hi.begin(), box.hi.end(), hi_);
  }

#if HWY_TARGET == HWY_SCALAR
  bool operator()(const TreeNode& node) const {
    float squared[3];
    for (int axis = 0; axis < 3; ++axis) {
      const float gap = std::max(std::max(node.box.lo[axis] - hi_[axis], lo_[axis] - node.box.hi[axis]), 0.0f);
      squared[axis] = gap * gap;
    }
    return (squared[0] + squared[1]) + squared[2] <= squared_reach_;
  }
#else
  bool operator()(const TreeNode& node) const {
    const hn::FixedTag<float, 4> d;
    // The fourth lanes of the loads are the members that follow, and not used.
    const auto above = hn::Sub(hn::LoadU(d, node.box.lo.data()), hn::Load(d, hi_));
    const auto below = hn::Sub(hn::Load(d, lo_), hn::LoadU(d, node.box.hi.data()));
    const auto gap = hn::Max(hn::Max(above, below), hn::Zero(d));
    const auto squared = hn::Mul(gap, gap);
    const auto x_y = hn::Add(squared, hn::Broadcast<1>(squared));
    return hn::GetLane(hn::Add(x_y, hn::Broadcast<2>(squared))) <= squared_reach_;
  }
#endif

  // The same for the leaves whose bounds these are.
  HWY_INLINE FloatMask Leaves(const float* const lo[3], const float* const hi[3]) const {
    const FloatTag d;
    FloatVec squared[3];
    for (int axis = 0; axis < 3; ++axis) {
      const FloatVec above = hn::Sub(hn::LoadU(d, lo[axis]), hn::Set(d, hi_[axis]));
      const FloatVec below = hn::Sub(hn::Set(d, lo_[axis]), hn::LoadU(d, hi[axis]));
      const FloatVec gap = hn::Max(hn::Max(above, below), hn::Zero(d));
      squared[axis] = hn::Mul(gap, gap);
    }
    return hn::Le(hn::Add(hn::Add(squared[0], squared[1]), squared[2]), hn::Set(d, squared_reach_));
  }

  // The same for leaves first, first + 1, ... of an index; lanes past the last leaf hold any value.
  HWY_INLINE FloatMask LeavesFrom(const SpatialIndex& index, uint32_t first) const {
    const float *lo[3], *hi[3];
    for (int axis = 0; axis < 3; ++axis) {
      lo[axis] = index.leaf_lo(axis) + first;
      hi[axis] = index.leaf_hi(axis) + first;
    }
    return Leaves(lo, hi);
  }

 private:
  alignas(16) float lo_[4] = {};
  alignas(16) float hi_[4] = {};
  float squared_reach_;
};

// Appends the wanted ones of some leaves, with their bounds.
HWY_INLINE void AppendLeaves(const float* const lo[3], const float* const hi[3], hn::Vec<IntTag> ids, FloatMask wanted,
                             LeafList& leaves) {
  const FloatTag d;
  const IntTag di;
  const auto wanted_ids = hn::Compress(ids, hn::RebindMask(di, wanted));
  hn::StoreU(wanted_ids, di, reinterpret_cast<int32_t*>(leaves.end()));
  for (int axis = 0; axis < 3; ++axis) {
    hn::StoreU(hn::Compress(hn::LoadU(d, lo[axis]), wanted), d, leaves.lo_end(axis));
    hn::StoreU(hn::Compress(hn::LoadU(d, hi[axis]), wanted), d, leaves.hi_end(axis));
  }
  leaves.Keep(hn::CountTrue(d, wanted));
}

// Appends those of leaves [first, first + count) that meet the reach.
HWY_INLINE void AppendMeeting(const SpatialIndex& index, const ReachTest& meets, uint32_t first, uint32_t count,
                              LeafList& leaves) {
  const FloatTag d;
  leaves.Reserve(leaves.size() + count);
  for (uint32_t i = 0; i < count; i += hn::Lanes(d)) {
    const float* lo[3];
    const float* hi[3];
    for (int axis = 0; axis < 3; ++axis) {
      lo[axis] = index.leaf_lo(axis) + first + i;
      hi[axis] = index.leaf_hi(axis) + first + i;
    }
    const FloatMask wanted = hn::And(meets.Leaves(lo, hi), hn::FirstN(d, count - i));
    AppendLeaves(lo, hi, IntsFrom(static_cast<int32_t>(first + i)), wanted, leaves);
  }
}

// Calls `visit(first_leaf, count)` in tree order for runs of leaves, of at most LeafList::kMostTested each, that cover
// every leaf all of whose nodes `enters` tells to enter. Ends when a visit returns false. Returns how many nodes it
// entered.
template <typename Enters, typename Visit>
HWY_INLINE size_t WalkLeaves(const SpatialIndex& index, const Enters& enters, const Visit& visit) {
  struct Pending {
    uint32_t node;
    uint32_t first_leaf;
    uint32_t leaves;
  };
  constexpr size_t kMaxDepth = 64;  // the tree is balanced over fewer than 2^31 leaves
  // A node over at most two vectors of leaves is not gone down: they are all tested.
  constexpr uint32_t kTested = 2 * hn::MaxLanes(FloatTag());
  static_assert(kTested <= LeafList::kMostTested);
  size_t entered = 0;
  if (index.leaf_count() == 0) return entered;
  // Nodes to enter. Children are written in any case and kept by the count: whether one meets a reach is what no branch
  // predictor knows.
  Pending stack[kMaxDepth];
  stack[0] = {0, 0, static_cast<uint32_t>(index.leaf_count())};
  size_t depth = enters(index.node(0)) ? 1 : 0;
  while (depth > 0) {
    const Pending top = stack[--depth];
    ++entered;
    if (top.leaves <= kTested) {
      if (!visit(top.first_leaf, top.leaves)) return entered;
      continue;
    }
    const auto left_leaves = static_cast<uint32_t>(SpatialIndex::LeftLeaves(top.leaves));
    const uint32_t left = top.node + 1;
    const auto right = static_cast<uint32_t>(SpatialIndex::RightChild(top.node, top.leaves));
    stack[depth] = {right, top.first_leaf + left_leaves, top.leaves - left_leaves};
    depth += enters(index.node(right)) ? 1 : 0;
    stack[depth] = {left, top.first_leaf, left_leaves};
    depth += enters(index.node(left)) ? 1 : 0;
  }
  return entered;
}

// Replaces the list by the leaves at squared distance <= `squared_reach` of `box`. Every point whose computed squared
// distance to a point of `box` is within it lies in one of them. Returns false, with the list undefined, if they are
// more than `max_leaves`; the list then holds memory for LeafList::kMostTested more at most. Adds its steps to `work`
// (SearchScratch::work).
HWY_NOINLINE inline bool GatherLeaves(const SpatialIndex& index, const Box& box, float squared_reach, size_t max_leaves,
                                      LeafList& leaves, uint64_t& work) {
  const ReachTest meets(box, squared_reach);
  leaves.Clear();
  size_t tested = 0;
  const size_t entered = WalkLeaves(index, meets, [&](uint32_t first, uint32_t count) HWY_ATTR {
    tested += count;
    AppendMeeting(index, meets, first, count, leaves);
    return leaves.size() <= max_leaves;
  });
  work += entered + tested;
  if (leaves.size() > max_leaves) return false;
  leaves.Pad();
  return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_SEARCH_GATHER_LEAVES_INL_H_
