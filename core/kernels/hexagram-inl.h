// The hexagram: six corners around a point in its tangent plane, two triangles over them (Lachaud et al. 2023,
// section 4). The corners are the points nearest to six targets, or averages over six sectors of the neighborhood.

#if defined(CURVD_CORE_KERNELS_HEXAGRAM_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_KERNELS_HEXAGRAM_INL_H_
#undef CURVD_CORE_KERNELS_HEXAGRAM_INL_H_
#else
#define CURVD_CORE_KERNELS_HEXAGRAM_INL_H_
#endif

#include <algorithm>
#include <cmath>

#include "core/group_buffers.h"
#include "core/kernels/measures-inl.h"
#include "core/kernels/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

inline constexpr float kSqrt3 = 1.7320508f;

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE void StoreFourSums(FloatVec a, FloatVec b, FloatVec c, FloatVec e, float* out) {
  out[0] = hn::GetLane(a);
  out[1] = hn::GetLane(b);
  out[2] = hn::GetLane(c);
  out[3] = hn::GetLane(e);
}

#else

// Sum over the blocks of four lanes of a vector.
template <class D>
HWY_INLINE auto SumBlocks([[maybe_unused]] D d, hn::Vec<D> v) {
  if constexpr (hn::MaxLanes(D()) <= 4) {
    return v;
  } else {
    const hn::Half<D> half;
    return SumBlocks(half, hn::Add(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  }
}

// Stores the lane sums of four vectors to out[0..3], by a transposition of their blocks.
HWY_INLINE void StoreFourSums(FloatVec a, FloatVec b, FloatVec c, FloatVec e, float* out) {
  const FloatTag d;
  const hn::RepartitionToWide<FloatTag> wide;
  const FloatVec ab = hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b));
  const FloatVec ce = hn::Add(hn::InterleaveLower(d, c, e), hn::InterleaveUpper(d, c, e));
  const auto low = hn::InterleaveLower(wide, hn::BitCast(wide, ab), hn::BitCast(wide, ce));
  const auto high = hn::InterleaveUpper(wide, hn::BitCast(wide, ab), hn::BitCast(wide, ce));
  hn::StoreU(SumBlocks(d, hn::Add(hn::BitCast(d, low), hn::BitCast(d, high))), hn::CappedTag<float, 4>(), out);
}

#endif

// Which sector of the tangent plane, 60 degrees wide around each target, each of a vector of offsets lies in. Offsets
// without a tangential part (the point itself, its doubles, padding) lie in none.
struct Sectors {
  FloatMask mask[6];
};

HWY_INLINE Sectors FindSectors(FloatVec along_u, FloatVec along_v) {
  const FloatTag d;
  const FloatVec zero = hn::Zero(d);
  // The bounding lines lie at 30, 90 and 150 degrees.
  const FloatVec steep = hn::Mul(along_v, hn::Set(d, kSqrt3));
  const FloatMask right = hn::Gt(along_u, zero);
  const FloatMask left = hn::Or(hn::Lt(along_u, zero), hn::AndNot(right, hn::Ne(along_v, zero)));
  const FloatMask above_30 = hn::Gt(steep, along_u);
  const FloatMask above_150 = hn::Gt(steep, hn::Neg(along_u));
  return {{hn::And(hn::AndNot(above_30, right), above_150), hn::And(right, above_30), hn::And(left, above_150),
           hn::And(hn::AndNot(above_150, left), above_30), hn::AndNot(above_30, left), hn::AndNot(above_150, right)}};
}

// sum + x where the mask is set, sum elsewhere.
HWY_INLINE FloatVec AddWhere(FloatMask mask, FloatVec sum, FloatVec x) {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
  return hn::IfThenElse(mask, hn::Add(sum, x), sum);  // one masked instruction
#else
  return hn::Add(sum, hn::IfThenElseZero(mask, x));
#endif
}

// The tangent frame of point i, turned by an angle.
HWY_INLINE Frame TurnedFrame(const GroupScratch::Buffers& b, size_t i, float cosine, float sine) {
  const FloatTag d;
  const float u[3] = {b.u.x[i], b.u.y[i], b.u.z[i]}, v[3] = {b.v.x[i], b.v.y[i], b.v.z[i]};
  float first[3], second[3];
  for (int axis = 0; axis < 3; ++axis) {
    first[axis] = cosine * u[axis] + sine * v[axis];
    second[axis] = cosine * v[axis] - sine * u[axis];
  }
  return {{hn::Set(d, first[0]), hn::Set(d, first[1]), hn::Set(d, first[2])},
          {hn::Set(d, second[0]), hn::Set(d, second[1]), hn::Set(d, second[2])}};
}

// Sums of one quantity of the neighbors over the sectors of a frame, component by component to sums[0..17]; `sums` has
// room for 20. `quantity(j)` gives it for neighbors j, j + 1, ...; `counts`, if asked for, gets the neighbors of each
// sector. One quantity a pass, so that all sums stay in registers.
template <bool kCounts, typename Quantity>
HWY_INLINE void SumOverSectors(const NeighborArrays& n, const Frame& frame, Quantity quantity, float* sums,
                               size_t* counts) {
  const FloatTag d;
  const FloatVec zero = hn::Zero(d);
  FloatVec x0 = zero, x1 = zero, x2 = zero, x3 = zero, x4 = zero, x5 = zero;
  FloatVec y0 = zero, y1 = zero, y2 = zero, y3 = zero, y4 = zero, y5 = zero;
  FloatVec z0 = zero, z1 = zero, z2 = zero, z3 = zero, z4 = zero, z5 = zero;
  for (size_t j = 0; j < n.count; j += hn::Lanes(d)) {
    const Triple offset{hn::Load(d, n.dx.data() + j), hn::Load(d, n.dy.data() + j), hn::Load(d, n.dz.data() + j)};
    const Sectors sectors = FindSectors(Dot(offset, frame.u), Dot(offset, frame.v));
    const FloatMask* mask = sectors.mask;
    if constexpr (kCounts) {
      for (int s = 0; s < 6; ++s) counts[s] += hn::CountTrue(d, mask[s]);
    }
    const Triple q = quantity(j);
    x0 = AddWhere(mask[0], x0, q.x), y0 = AddWhere(mask[0], y0, q.y), z0 = AddWhere(mask[0], z0, q.z);
    x1 = AddWhere(mask[1], x1, q.x), y1 = AddWhere(mask[1], y1, q.y), z1 = AddWhere(mask[1], z1, q.z);
    x2 = AddWhere(mask[2], x2, q.x), y2 = AddWhere(mask[2], y2, q.y), z2 = AddWhere(mask[2], z2, q.z);
    x3 = AddWhere(mask[3], x3, q.x), y3 = AddWhere(mask[3], y3, q.y), z3 = AddWhere(mask[3], z3, q.z);
    x4 = AddWhere(mask[4], x4, q.x), y4 = AddWhere(mask[4], y4, q.y), z4 = AddWhere(mask[4], z4, q.z);
    x5 = AddWhere(mask[5], x5, q.x), y5 = AddWhere(mask[5], y5, q.y), z5 = AddWhere(mask[5], z5, q.z);
  }
  StoreFourSums(x0, x1, x2, x3, sums);
  StoreFourSums(x4, x5, y0, y1, sums + 4);
  StoreFourSums(y2, y3, y4, y5, sums + 8);
  StoreFourSums(z0, z1, z2, z3, sums + 12);
  StoreFourSums(z4, z5, zero, zero, sums + 16);
}

// Sets a hexagram of point i to the sums of its neighbors over the sectors of a turned frame.
HWY_INLINE void SumCorners(const GroupScratch::Buffers& b, size_t i, float cosine, float sine, Hexagram& out) {
  const FloatTag d;
  const NeighborArrays& n = b.neighbors;
  const Frame frame = TurnedFrame(b, i, cosine, sine);
  // Normals are summed relative to the point's own: their differences are what the measures need to full precision.
  const Triple own{hn::Set(d, b.normal.x[i]), hn::Set(d, b.normal.y[i]), hn::Set(d, b.normal.z[i])};
  const auto offset = [&](size_t j) {
    return Triple{hn::Load(d, n.dx.data() + j), hn::Load(d, n.dy.data() + j), hn::Load(d, n.dz.data() + j)};
  };
  const auto normal = [&](size_t j) {
    const Triple full{hn::Load(d, n.nx.data() + j), hn::Load(d, n.ny.data() + j), hn::Load(d, n.nz.data() + j)};
    return Sub(full, own);
  };
  size_t counts[6] = {};
  float offsets[20], normals[20];
  SumOverSectors<true>(n, frame, offset, offsets, counts);
  SumOverSectors<false>(n, frame, normal, normals, nullptr);
  for (int s = 0; s < 6; ++s) {
    out.offset[s].x[i] = offsets[s];
    out.offset[s].y[i] = offsets[6 + s];
    out.offset[s].z[i] = offsets[12 + s];
    out.normal[s].x[i] = normals[s];
    out.normal[s].y[i] = normals[6 + s];
    out.normal[s].z[i] = normals[12 + s];
    out.count[s][i] = static_cast<float>(counts[s]);
  }
}

// Sets all hexagrams of point i, turned evenly between one sector and the next.
HWY_INLINE void SumHexagrams(const EstimationPlan& plan, GroupScratch::Buffers& b, size_t i) {
  for (int r = 0; r < plan.rotations; ++r) SumCorners(b, i, plan.cosine[r], plan.sine[r], b.hexagrams[r]);
}

// The slot in tree order of the listed leaves' point nearest to `target`, ties to the lower id, if any is within the
// squared reach; else -1.
HWY_INLINE int32_t FindNearest(const SpatialIndex& index, const LeafList& leaves, const float* target,
                               float squared_reach, ScratchArray<uint32_t>& near) {
  const FloatTag d;
  const IntTag di;
  constexpr int32_t kLeaf = SpatialIndex::kLeafSize;
  const FloatVec tx = hn::Set(d, target[0]), ty = hn::Set(d, target[1]), tz = hn::Set(d, target[2]);
  const size_t near_count = CullLeaves(leaves, target, squared_reach, near);
  // Of each lane the nearest point so far.
  FloatVec best = hn::Set(d, squared_reach);
  auto best_id = hn::Set(di, SpatialIndex::kPaddingId);
  auto best_slot = hn::Set(di, -1);
  for (size_t j = 0; j < near_count; ++j) {
    const SpatialIndex::LeafPositions& points = index.positions(near[j]);
    for (int32_t i = 0; i < kLeaf; i += static_cast<int32_t>(hn::Lanes(d))) {
      const FloatVec squared =
          SquaredNorm(hn::Sub(hn::Load(d, points.x + i), tx), hn::Sub(hn::Load(d, points.y + i), ty),
                      hn::Sub(hn::Load(d, points.z + i), tz));
      const auto id = hn::Load(di, points.id + i);
      const FloatMask tied = hn::And(hn::Eq(squared, best), hn::RebindMask(d, hn::Lt(id, best_id)));
      const FloatMask better = hn::Or(hn::Lt(squared, best), tied);
      best = hn::IfThenElse(better, squared, best);
      best_id = hn::IfThenElse(hn::RebindMask(di, better), id, best_id);
      best_slot = hn::IfThenElse(hn::RebindMask(di, better), hn::Iota(di, static_cast<int32_t>(near[j]) * kLeaf + i),
                                 best_slot);
    }
  }
  const FloatMask nearest = hn::Eq(best, hn::MinOfLanes(d, best));
  alignas(64) int32_t slots[SpatialIndex::kLeafSize], ids[SpatialIndex::kLeafSize];
  hn::Store(best_slot, di, slots);
  if (HWY_LIKELY(hn::CountTrue(d, nearest) == 1)) return slots[hn::FindFirstTrue(d, nearest)];
  // Lanes without a point have the padding's id, which is above all others.
  hn::Store(hn::IfThenElse(hn::RebindMask(di, nearest), best_id, hn::Set(di, SpatialIndex::kPaddingId)), di, ids);
  return slots[std::min_element(ids, ids + hn::Lanes(di)) - ids];
}

// The same without a bound, by descent of the tree.
HWY_NOINLINE inline int32_t FindNearestByDescent(const SpatialIndex& index, const float* target,
                                                 GroupScratch::Buffers& b) {
  const NeighborRank rank = KthNeighbor(index, target, 1, b.heap);
  const Box point{{target[0], target[1], target[2]}, {target[0], target[1], target[2]}};
  b.own_leaves.Gather(index, point, rank.squared_distance, index.leaf_count());
  return FindNearest(index, b.own_leaves, target, rank.squared_distance, b.near);
}

// The target at s * 60 degrees and distance rho of point i.
HWY_INLINE void SetTarget(const GroupScratch::Buffers& b, size_t i, int s, float* target) {
  constexpr float kCos[6] = {1.0f, 0.5f, -0.5f, -1.0f, -0.5f, 0.5f};
  constexpr float kSin[6] = {0.0f, kSqrt3 / 2, kSqrt3 / 2, 0.0f, -kSqrt3 / 2, -kSqrt3 / 2};
  const float along_u = b.rho[i] * kCos[s], along_v = b.rho[i] * kSin[s];
  target[0] = b.query[i][0] + along_u * b.u.x[i] + along_v * b.v.x[i];
  target[1] = b.query[i][1] + along_u * b.u.y[i] + along_v * b.v.y[i];
  target[2] = b.query[i][2] + along_u * b.u.z[i] + along_v * b.v.z[i];
}

HWY_INLINE void SetCorner(const SpatialIndex& index, int32_t slot, size_t i, int s, GroupScratch::Buffers& b) {
  const SpatialIndex::LeafPositions& points = index.positions(slot / SpatialIndex::kLeafSize);
  const SpatialIndex::LeafNormals& normals = index.normals(slot / SpatialIndex::kLeafSize);
  const int lane = slot % SpatialIndex::kLeafSize;
  Hexagram& hexagram = b.hexagrams[0];
  hexagram.offset[s].x[i] = points.x[lane] - b.query[i][0];
  hexagram.offset[s].y[i] = points.y[lane] - b.query[i][1];
  hexagram.offset[s].z[i] = points.z[lane] - b.query[i][2];
  hexagram.normal[s].x[i] = normals.x[lane] - b.normal.x[i];
  hexagram.normal[s].y[i] = normals.y[lane] - b.normal.y[i];
  hexagram.normal[s].z[i] = normals.z[lane] - b.normal.z[i];
  hexagram.count[s][i] = 1.0f;
}

// Lists the leaves around the targets of corners [first, last) of all points, to a reach within which an even surface
// has a point. Returns the squared reach, or a negative value if there are too many leaves or no targets.
HWY_INLINE float ListTargets(const SpatialIndex& index, int first, int last, size_t max_leaves,
                             GroupScratch::Buffers& b) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  float reach = 0.0f;
  for (size_t i = 0; i < b.size; ++i) {
    if (b.status[i] != PointStatus::kOk) continue;
    reach = std::max(reach, b.nearest_reach[i]);
    for (int s = first; s < last; ++s) {
      float target[3];
      SetTarget(b, i, s, target);
      for (int axis = 0; axis < 3; ++axis) {
        box.lo[axis] = std::min(box.lo[axis], target[axis]);
        box.hi[axis] = std::max(box.hi[axis], target[axis]);
      }
    }
  }
  const float squared_reach = reach * reach;
  return reach > 0.0f && b.leaves.Gather(index, box, squared_reach, max_leaves) ? squared_reach : -1.0f;
}

// Sets corners [first, last) of every point from a list of leaves that holds all points near their targets, if
// `squared_reach` is not negative.
HWY_INLINE void SetCorners(const SpatialIndex& index, int first, int last, float squared_reach,
                           GroupScratch::Buffers& b) {
  for (size_t i = 0; i < b.size; ++i) {
    if (b.status[i] != PointStatus::kOk) continue;
    // Most targets have a point within half their reach; the ball with a quarter of the area meets fewer leaves.
    const float squared_half = 0.25f * b.nearest_reach[i] * b.nearest_reach[i];
    for (int s = first; s < last; ++s) {
      float target[3];
      SetTarget(b, i, s, target);
      int32_t slot = -1;
      if (squared_reach >= 0.0f) {
        slot = FindNearest(index, b.leaves, target, std::min(squared_half, squared_reach), b.near);
        if (slot < 0) slot = FindNearest(index, b.leaves, target, squared_reach, b.near);
      }
      if (slot < 0) slot = FindNearestByDescent(index, target, b);
      SetCorner(index, slot, i, s, b);
    }
  }
}

// Sets each point's corners to the points of the cloud nearest to its six targets. One list of leaves serves all of
// them, or where the figure is large against the group, one for each corner.
HWY_INLINE void NearestCorners(const SpatialIndex& index, GroupScratch::Buffers& b) {
  constexpr size_t kMaxShared = 64, kMaxSingle = 512;
  const float squared_reach = ListTargets(index, 0, 6, kMaxShared, b);
  if (squared_reach >= 0.0f) return SetCorners(index, 0, 6, squared_reach, b);
  for (int s = 0; s < 6; ++s) SetCorners(index, s, s + 1, ListTargets(index, s, s + 1, kMaxSingle, b), b);
}

// The corner that sums over a sector give, in units of rho: the averages, with the average normal brought back to unit
// length, since noise shortens it and with it every curvature (docs/numerics.md). A sector without neighbors leaves its
// corner at the point itself: the triangle over the other corners still counts.
HWY_INLINE Corner AverageCorner(const Hexagram& hexagram, int s, const Triple& own, FloatVec per_rho, size_t i) {
  const FloatTag d;
  const FloatVec one = hn::Set(d, 1.0f);
  const FloatVec per_count = hn::Div(one, hn::Max(hn::Load(d, hexagram.count[s] + i), one));
  const Triple offset = Scale(LoadTriple(hexagram.offset[s], i), hn::Mul(per_count, per_rho));
  const Triple mean = Scale(LoadTriple(hexagram.normal[s], i), per_count);
  // With L = |own + mean|, the unit normal less the own is (mean - (L - 1) own) / L. L - 1 comes from L^2 - 1, which is
  // small and loses no digits. Opposite normals may average to nothing; L stays away from zero.
  const FloatVec squared_excess = Dot(Add(Add(own, own), mean), mean);
  const FloatVec length = hn::Sqrt(hn::Max(hn::Add(one, squared_excess), hn::Set(d, 0.01f)));
  const FloatVec excess = hn::Div(squared_excess, hn::Add(length, one));
  return {offset, Scale(Sub(mean, Scale(own, excess)), hn::Div(one, length))};
}

// Adds the measures of both triangles of a hexagram, for points i, i + 1, ... at once.
HWY_INLINE void AddHexagram(const Hexagram& hexagram, const Frame& frame, const Triple& own, FloatVec per_rho, size_t i,
                            Measures& sum) {
  for (int first = 0; first < 2; ++first) {
    Corner corners[3];
    for (int c = 0; c < 3; ++c) corners[c] = AverageCorner(hexagram, first + 2 * c, own, per_rho, i);
    AddTriangle(frame, own, corners, sum);
  }
}

// Measures of the hexagrams of all points of the group.
HWY_INLINE void MeasureHexagrams(int rotations, GroupScratch::Buffers& b) {
  const FloatTag d;
  for (size_t i = 0; i < b.size; i += hn::Lanes(d)) {
    const Frame frame{LoadTriple(b.u, i), LoadTriple(b.v, i)};
    const Triple own = LoadTriple(b.normal, i);
    const FloatVec per_rho = hn::Div(hn::Set(d, 1.0f), hn::Load(d, b.rho + i));
    Measures measures = ZeroMeasures();
    for (int r = 0; r < rotations; ++r) AddHexagram(b.hexagrams[r], frame, own, per_rho, i, measures);
    StoreMeasures(measures, i, b.measures);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_KERNELS_HEXAGRAM_INL_H_
