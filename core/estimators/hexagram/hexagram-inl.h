// The hexagram: six corners around a point in its tangent plane, two triangles over them (Lachaud et al. 2023,
// section 4). The corners are averages over six sectors of the neighborhood, or the points nearest to six targets
// (core/estimators/hexagram/nearest_corners-inl.h).

#if defined(CURVD_CORE_ESTIMATORS_HEXAGRAM_HEXAGRAM_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_HEXAGRAM_HEXAGRAM_INL_H_
#undef CURVD_CORE_ESTIMATORS_HEXAGRAM_HEXAGRAM_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_HEXAGRAM_HEXAGRAM_INL_H_
#endif

#include "core/estimators/group_scratch.h"
#include "core/estimators/hexagram/hexagram.h"
#include "core/estimators/measures-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// The corner that sums over a sector give, in units of rho: the averages, with the average normal brought back to unit
// length, since noise shortens it and with it every curvature (docs/numerics.md). A sector without neighbors leaves its
// corner at the point itself: the triangle over the other corners still counts.
HWY_INLINE Corner AverageCorner(const Hexagram& hexagram, int s, const Triple& own, FloatVec per_rho, size_t i) {
  const FloatTag d;
  const FloatVec one = hn::Set(d, 1.0f);
  Triple offsets, normals;
  FloatVec count, nothing;
  hn::LoadInterleaved4(d, hexagram.offset[s][i], offsets.x, offsets.y, offsets.z, count);
  hn::LoadInterleaved4(d, hexagram.normal[s][i], normals.x, normals.y, normals.z, nothing);
  const FloatVec per_count = hn::Div(one, hn::Max(count, one));
  const Triple offset = Scale(offsets, hn::Mul(per_count, per_rho));
  const Triple mean = Scale(normals, per_count);
  // With L = |own + mean|, the unit normal less the own is (mean - (L - 1) own) / L. L - 1 comes from L^2 - 1, which is
  // small and loses no digits. Opposite normals may average to nothing; L stays at least 0.1, in both places.
  const FloatVec squared_excess = hn::Max(Dot(Add(Add(own, own), mean), mean), hn::Set(d, -0.99f));
  const FloatVec length = hn::Sqrt(hn::Add(one, squared_excess));
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

// Measures the first `rotations` hexagrams of all points of the group.
HWY_NOINLINE inline void MeasureHexagrams(const Hexagram* hexagrams, int rotations, MeasuringScratch& scratch) {
  const FloatTag d;
  for (size_t i = 0; i < scratch.points.size; i += hn::Lanes(d)) {
    const Frame frame{LoadTriple(scratch.frames.u, i), LoadTriple(scratch.frames.v, i)};
    const Triple own = LoadTriple(scratch.points.normal, i);
    const FloatVec per_rho = hn::Div(hn::Set(d, 1.0f), hn::Load(d, scratch.frames.rho + i));
    Measures measures = ZeroMeasures();
    for (int r = 0; r < rotations; ++r) AddHexagram(hexagrams[r], frame, own, per_rho, i, measures);
    StoreMeasures(measures, i, scratch.measures);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_HEXAGRAM_HEXAGRAM_INL_H_
