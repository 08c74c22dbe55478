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
HWY_INLINE auto SumBlocks(D d, hn::Vec<D> v) {
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

// Sums over the six sectors of one quantity's three components; `sums` gets 18 values, component by component.
HWY_INLINE void AddToSectors(const Sectors& sectors, FloatVec x, FloatVec y, FloatVec z, FloatVec* sums) {
  HWY_UNROLL(6)
  for (int s = 0; s < 6; ++s) {
    sums[s] = hn::Add(sums[s], hn::IfThenElseZero(sectors.mask[s], x));
    sums[6 + s] = hn::Add(sums[6 + s], hn::IfThenElseZero(sectors.mask[s], y));
    sums[12 + s] = hn::Add(sums[12 + s], hn::IfThenElseZero(sectors.mask[s], z));
  }
}

// Stores the lane sums of 18 vectors to out[0..17]; out has room for 20.
HWY_INLINE void StoreSums(const FloatVec* sums, float* out) {
  const FloatVec zero = hn::Zero(FloatTag());
  HWY_UNROLL(4)
  for (int i = 0; i < 16; i += 4) StoreFourSums(sums[i], sums[i + 1], sums[i + 2], sums[i + 3], out + i);
  StoreFourSums(sums[16], sums[17], zero, zero, out + 16);
}

// Directions of a hexagram's first axis in the tangent frame, and of the axis after it.
struct Turn {
  Triple first, second;
};

// The tangent frame of point i turned by `angle` radians.
HWY_INLINE Turn TurnedFrame(const GroupScratch::Buffers& b, size_t i, float angle) {
  const FloatTag d;
  const float c = std::cos(angle), s = std::sin(angle);
  const float u[3] = {b.u.x[i], b.u.y[i], b.u.z[i]}, v[3] = {b.v.x[i], b.v.y[i], b.v.z[i]};
  return {{hn::Set(d, c * u[0] + s * v[0]), hn::Set(d, c * u[1] + s * v[1]), hn::Set(d, c * u[2] + s * v[2])},
          {hn::Set(d, c * v[0] - s * u[0]), hn::Set(d, c * v[1] - s * u[1]), hn::Set(d, c * v[2] - s * u[2])}};
}

// Sets corner s of point i to the averages that the sums over its sector give. The average normal is brought back to
// unit length: noise shortens it, and with it every curvature (docs/numerics.md). A sector without neighbors leaves
// its corner at the point itself: the triangle over the other corners still counts.
HWY_INLINE void StoreCorner(const float* offset_sums, const float* normal_sums, size_t count, int s,
                            const GroupVectors& own, size_t i, Hexagram& out) {
  const float weight = count > 0 ? 1.0f / static_cast<float>(count) : 0.0f;
  const float offset[3] = {offset_sums[s] * weight, offset_sums[6 + s] * weight, offset_sums[12 + s] * weight};
  out.offset[s].Set(i, offset);
  const float n[3] = {own.x[i], own.y[i], own.z[i]};
  const float mean[3] = {normal_sums[s] * weight, normal_sums[6 + s] * weight, normal_sums[12 + s] * weight};
  // With L = |n + mean|: (n + mean) / L - n, by L^2 - 1, which is small and loses no digits.
  float squared_excess = 0.0f;
  for (int axis = 0; axis < 3; ++axis) squared_excess += (n[axis] + n[axis] + mean[axis]) * mean[axis];
  const float length = std::sqrt(std::max(1.0f + squared_excess, 0.01f));
  const float excess = squared_excess / (length + 1.0f);
  float normal[3];
  for (int axis = 0; axis < 3; ++axis) normal[axis] = (mean[axis] - excess * n[axis]) / length;
  out.normal[s].Set(i, normal);
}

// Sets a hexagram of point i to the averages of its neighbors over the sectors of a turned frame.
HWY_INLINE void AverageCorners(const GroupScratch::Buffers& b, size_t i, float angle, Hexagram& out) {
  const FloatTag d;
  const NeighborArrays& n = b.neighbors;
  const Turn turn = TurnedFrame(b, i, angle);
  // Normals are summed relative to the point's own: their differences are what the measures need to full precision.
  const FloatVec own_x = hn::Set(d, b.normal.x[i]), own_y = hn::Set(d, b.normal.y[i]),
                 own_z = hn::Set(d, b.normal.z[i]);
  size_t counts[6] = {};
  FloatVec offsets[18], normals[18];
  for (int s = 0; s < 18; ++s) offsets[s] = normals[s] = hn::Zero(d);
  for (size_t j = 0; j < n.count; j += hn::Lanes(d)) {
    const Triple offset{hn::Load(d, n.dx.data() + j), hn::Load(d, n.dy.data() + j), hn::Load(d, n.dz.data() + j)};
    const Sectors sectors = FindSectors(Dot(offset, turn.first), Dot(offset, turn.second));
    for (int s = 0; s < 6; ++s) counts[s] += hn::CountTrue(d, sectors.mask[s]);
    AddToSectors(sectors, offset.x, offset.y, offset.z, offsets);
    AddToSectors(sectors, hn::Sub(hn::Load(d, n.nx.data() + j), own_x), hn::Sub(hn::Load(d, n.ny.data() + j), own_y),
                 hn::Sub(hn::Load(d, n.nz.data() + j), own_z), normals);
  }
  alignas(64) float offset_sums[20], normal_sums[20];
  StoreSums(offsets, offset_sums);
  StoreSums(normals, normal_sums);
  for (int s = 0; s < 6; ++s) StoreCorner(offset_sums, normal_sums, counts[s], s, b.normal, i, out);
}

// Sets all hexagrams of point i, turned evenly between one sector and the next.
HWY_INLINE void AverageHexagrams(int rotations, GroupScratch::Buffers& b, size_t i) {
  constexpr float kSector = 1.04719755f;
  for (int r = 0; r < rotations; ++r) {
    AverageCorners(b, i, kSector * static_cast<float>(r) / static_cast<float>(rotations), b.hexagrams[r]);
  }
}

// The nearest of the listed leaves' points to `target`, ties to the lower id, if any is within the squared reach.
struct NearestPoint {
  float squared_distance;
  uint32_t leaf;
  int slot = -1;  // -1: none within reach
};

HWY_INLINE NearestPoint FindNearest(const SpatialIndex& index, const LeafList& leaves, const float* target,
                                    float squared_reach, ScratchArray<uint32_t>& near) {
  const FloatTag d;
  const IntTag di;
  const FloatVec tx = hn::Set(d, target[0]), ty = hn::Set(d, target[1]), tz = hn::Set(d, target[2]);
  const size_t near_count = CullLeaves(leaves, target, squared_reach, near);
  NearestPoint best{squared_reach, 0, -1};
  int32_t best_id = SpatialIndex::kPaddingId;
  for (size_t j = 0; j < near_count; ++j) {
    const SpatialIndex::LeafPositions& points = index.positions(near[j]);
    for (size_t i = 0; i < SpatialIndex::kLeafSize; i += hn::Lanes(d)) {
      const FloatVec squared =
          SquaredNorm(hn::Sub(hn::Load(d, points.x + i), tx), hn::Sub(hn::Load(d, points.y + i), ty),
                      hn::Sub(hn::Load(d, points.z + i), tz));
      if (hn::AllFalse(d, hn::Le(squared, hn::Set(d, best.squared_distance)))) continue;
      const float least = hn::GetLane(hn::MinOfLanes(d, squared));
      const FloatMask at_least = hn::Eq(squared, hn::Set(d, least));
      const auto ids = hn::IfThenElse(hn::RebindMask(di, at_least), hn::Load(di, points.id + i),
                                      hn::Set(di, SpatialIndex::kPaddingId));
      const int32_t id = hn::GetLane(hn::MinOfLanes(di, ids));
      if (least == best.squared_distance && id >= best_id) continue;
      best_id = id;
      best.squared_distance = least;
      best.leaf = near[j];
      for (size_t s = i; s < i + hn::Lanes(d); ++s) {
        if (points.id[s] == id) best.slot = static_cast<int>(s);
      }
    }
  }
  return best;
}

// The same without a bound, by descent of the tree.
HWY_NOINLINE NearestPoint FindNearestByDescent(const SpatialIndex& index, const float* target,
                                               GroupScratch::Buffers& b) {
  const NeighborRank rank = KthNeighbor(index, target, 1, b.heap);
  const Box point{{target[0], target[1], target[2]}, {target[0], target[1], target[2]}};
  b.own_leaves.Gather(index, point, rank.squared_distance, index.leaf_count());
  return FindNearest(index, b.own_leaves, target, rank.squared_distance, b.near);
}

// Sets corner s of every point to the cloud's point nearest to the target at s * 60 degrees and distance rho.
HWY_INLINE void NearestCorners(const SpatialIndex& index, int s, GroupScratch::Buffers& b) {
  constexpr float kCos[6] = {1.0f, 0.5f, -0.5f, -1.0f, -0.5f, 0.5f};
  constexpr float kSin[6] = {0.0f, kSqrt3 / 2, kSqrt3 / 2, 0.0f, -kSqrt3 / 2, -kSqrt3 / 2};
  constexpr size_t kMaxLeaves = 128;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  float targets[SpatialIndex::kGroupPoints][3];
  Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  float reach = 0.0f;
  for (size_t i = 0; i < b.size; ++i) {
    if (b.status[i] != PointStatus::kOk) continue;
    const float along_u = b.rho[i] * kCos[s], along_v = b.rho[i] * kSin[s];
    targets[i][0] = b.query[i][0] + along_u * b.u.x[i] + along_v * b.v.x[i];
    targets[i][1] = b.query[i][1] + along_u * b.u.y[i] + along_v * b.v.y[i];
    targets[i][2] = b.query[i][2] + along_u * b.u.z[i] + along_v * b.v.z[i];
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] = std::min(box.lo[axis], targets[i][axis]);
      box.hi[axis] = std::max(box.hi[axis], targets[i][axis]);
    }
    reach = std::max(reach, b.nearest_reach[i]);
  }
  if (box.lo[0] > box.hi[0]) return;
  const float squared_reach = reach * reach;
  const bool listed = b.leaves.Gather(index, box, squared_reach, kMaxLeaves);
  for (size_t i = 0; i < b.size; ++i) {
    if (b.status[i] != PointStatus::kOk) continue;
    NearestPoint nearest{0.0f, 0, -1};
    if (listed) nearest = FindNearest(index, b.leaves, targets[i], squared_reach, b.near);
    if (nearest.slot < 0) nearest = FindNearestByDescent(index, targets[i], b);
    const SpatialIndex::LeafPositions& points = index.positions(nearest.leaf);
    const SpatialIndex::LeafNormals& normals = index.normals(nearest.leaf);
    b.hexagrams[0].offset[s].x[i] = points.x[nearest.slot] - b.query[i][0];
    b.hexagrams[0].offset[s].y[i] = points.y[nearest.slot] - b.query[i][1];
    b.hexagrams[0].offset[s].z[i] = points.z[nearest.slot] - b.query[i][2];
    b.hexagrams[0].normal[s].x[i] = normals.x[nearest.slot] - b.normal.x[i];
    b.hexagrams[0].normal[s].y[i] = normals.y[nearest.slot] - b.normal.y[i];
    b.hexagrams[0].normal[s].z[i] = normals.z[nearest.slot] - b.normal.z[i];
  }
}

// Adds the measures of both triangles of a hexagram, for points i, i + 1, ... at once.
HWY_INLINE void AddHexagram(const Hexagram& hexagram, const Frame& frame, const Triple& own, FloatVec unit, size_t i,
                            Measures& sum) {
  for (int first = 0; first < 2; ++first) {
    Corner corners[3];
    for (int c = 0; c < 3; ++c) {
      const int s = first + 2 * c;
      corners[c] = {Scale(LoadTriple(hexagram.offset[s], i), unit), LoadTriple(hexagram.normal[s], i)};
    }
    AddTriangle(frame, own, corners, sum);
  }
}

// Measures of the hexagrams of all points of the group.
HWY_INLINE void MeasureHexagrams(int rotations, GroupScratch::Buffers& b) {
  const FloatTag d;
  for (size_t i = 0; i < b.size; i += hn::Lanes(d)) {
    const Frame frame{LoadTriple(b.u, i), LoadTriple(b.v, i)};
    const Triple own = LoadTriple(b.normal, i);
    const FloatVec unit = hn::Div(hn::Set(d, 1.0f), hn::Load(d, b.rho + i));
    Measures measures = ZeroMeasures();
    for (int r = 0; r < rotations; ++r) AddHexagram(b.hexagrams[r], frame, own, unit, i, measures);
    StoreMeasures(measures, i, b.measures);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_KERNELS_HEXAGRAM_INL_H_
