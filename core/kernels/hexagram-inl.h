// The hexagram: six corners around a point in its tangent plane, two triangles over them (Lachaud et al. 2023,
// section 4). The corners are averages over six sectors of the neighborhood, or the points nearest to six targets
// (core/kernels/nearest_corners-inl.h).

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
