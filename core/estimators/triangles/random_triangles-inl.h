// Triangles with random corners in a neighborhood (Lachaud et al. 2023, section 4: uniform and independent).

#if defined(CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_TRIANGLES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_TRIANGLES_INL_H_
#undef CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_TRIANGLES_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_TRIANGLES_INL_H_
#endif

#include <cstddef>

#include "core/estimators/frames.h"
#include "core/estimators/group_scratch.h"
#include "core/estimators/measures-inl.h"
#include "core/estimators/rows/point_rows.h"
#include "core/estimators/rows/quads-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Mean area of triangles with random corners in a disc, in units of rho^2: 35 / (48 pi).
inline constexpr float kUsualTriangleArea = 0.232f;

// The first three numbers of rows of four, as LoadQuads loads them.
template <typename At>
HWY_INLINE Triple LoadTriples(At at) {
  const Quads<FloatTag> rows = LoadQuads(FloatTag(), at);
  return {rows.x, rows.y, rows.z};
}

// Adds the measures of the `used` of a vector of triangles over neighbors of point i. `row(c, lane)` is the row of
// corner c of each (core/estimators/rows/point_rows.h).
template <typename Row>
HWY_INLINE void AddRowTriangles(const GroupScratch& s, size_t i, Row row, FloatMask used, Measures& sum) {
  const FloatTag d;
  const Frame frame{Broadcast(s.frames.u, i), Broadcast(s.frames.v, i)};
  const Triple query = Broadcast(s.points.query, i), own = Broadcast(s.points.normal, i);
  const FloatVec unit = hn::Set(d, 1.0f / s.frames.rho[i]);
  Corner corners[3];
  for (int c = 0; c < 3; ++c) {
    const Triple position = LoadTriples([&](size_t lane) HWY_ATTR { return row(c, lane); });
    const Triple normal = LoadTriples([&](size_t lane) HWY_ATTR { return row(c, lane) + PointRows::kNormal; });
    corners[c] = {Scale(Sub(position, query), unit), Sub(normal, own)};
  }
  Measures added = ZeroMeasures();
  AddTriangle(frame, own, corners, added);
  sum.area = AddWhere(used, sum.area, added.area);
  sum.mean = AddWhere(used, sum.mean, added.mean);
  sum.gaussian = AddWhere(used, sum.gaussian, added.gaussian);
  sum.tensor_uu = AddWhere(used, sum.tensor_uu, added.tensor_uu);
  sum.tensor_uv = AddWhere(used, sum.tensor_uv, added.tensor_uv);
  sum.tensor_vv = AddWhere(used, sum.tensor_vv, added.tensor_vv);
}

// Stores the mean over `triangles` triangles of each measure for point i.
HWY_INLINE void StoreMeanMeasures(const Measures& sum, size_t triangles, size_t i, GroupMeasures& out) {
  const float weight = 1.0f / static_cast<float>(triangles);
  alignas(16) float sums[8];
  StoreFourSums(sum.area, sum.mean, sum.gaussian, sum.tensor_uu, sums);
  StoreFourSums(sum.tensor_uv, sum.tensor_vv, sum.tensor_uv, sum.tensor_vv, sums + 4);
  out.area[i] = sums[0] * weight;
  out.mean[i] = sums[1] * weight;
  out.gaussian[i] = sums[2] * weight;
  out.tensor_uu[i] = sums[3] * weight;
  out.tensor_uv[i] = sums[4] * weight;
  out.tensor_vv[i] = sums[5] * weight;
}

// Measures `triangles` triangles over the neighbors of point i. `draw(t)` draws those from t on, as many as a vector
// has lanes, and returns their rows, as `row` of AddRowTriangles.
template <typename Draw>
HWY_INLINE void MeasureTriangles(size_t i, size_t triangles, Draw draw, MeasuringScratch& s) {
  const FloatTag d;
  Measures sum = ZeroMeasures();
  for (size_t t = 0; t < triangles; t += hn::Lanes(d)) {
    AddRowTriangles(s, i, draw(t), hn::FirstN(d, triangles - t), sum);
  }
  StoreMeanMeasures(sum, triangles, i, s.measures);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_TRIANGLES_INL_H_
