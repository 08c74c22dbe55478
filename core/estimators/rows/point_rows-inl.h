// Writes the rows of points (core/estimators/rows/point_rows.h).

#if defined(CURVD_CORE_ESTIMATORS_ROWS_POINT_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_ROWS_POINT_ROWS_INL_H_
#undef CURVD_CORE_ESTIMATORS_ROWS_POINT_ROWS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_ROWS_POINT_ROWS_INL_H_
#endif

#include <algorithm>

#include "core/estimators/rows/point_rows.h"
#include "core/index/vectors-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE void WriteRows(const SpatialIndex::LeafPositions& points, const SpatialIndex::LeafNormals& normals,
                          float* rows) {
  for (size_t i = 0; i < SpatialIndex::kLeafSize; ++i) {
    const float row[PointRows::kRow] = {points.x[i],  points.y[i],  points.z[i],  1.0f,
                                        normals.x[i], normals.y[i], normals.z[i], 0.0f};
    std::copy(row, row + PointRows::kRow, rows + i * PointRows::kRow);
  }
}

#else

// Writes four columns of four rows.
HWY_INLINE void WriteColumns(const float* x, const float* y, const float* z, float last, float* rows) {
  const hn::FixedTag<float, 4> d;
  const auto vx = hn::Load(d, x), vy = hn::Load(d, y), vz = hn::Load(d, z), vw = hn::Set(d, last);
  const auto xy_01 = hn::InterleaveLower(d, vx, vy), xy_23 = hn::InterleaveUpper(d, vx, vy);
  const auto zw_01 = hn::InterleaveLower(d, vz, vw), zw_23 = hn::InterleaveUpper(d, vz, vw);
  hn::Store(hn::ConcatLowerLower(d, zw_01, xy_01), d, rows);
  hn::Store(hn::ConcatUpperUpper(d, zw_01, xy_01), d, rows + PointRows::kRow);
  hn::Store(hn::ConcatLowerLower(d, zw_23, xy_23), d, rows + 2 * PointRows::kRow);
  hn::Store(hn::ConcatUpperUpper(d, zw_23, xy_23), d, rows + 3 * PointRows::kRow);
}

HWY_INLINE void WriteRows(const SpatialIndex::LeafPositions& points, const SpatialIndex::LeafNormals& normals,
                          float* rows) {
  for (size_t i = 0; i < SpatialIndex::kLeafSize; i += 4) {
    WriteColumns(points.x + i, points.y + i, points.z + i, 1.0f, rows + i * PointRows::kRow);
    WriteColumns(normals.x + i, normals.y + i, normals.z + i, 0.0f, rows + i * PointRows::kRow + 4);
  }
}

#endif

// The first row of a leaf at a position of the list, which is written unless it has been.
HWY_INLINE uint32_t FirstRow(const SpatialIndex& index, uint32_t leaf, uint32_t position, PointRows& rows) {
  const uint32_t known = rows.first(position);
  if (HWY_LIKELY(known != PointRows::kNone)) return known;
  const uint32_t first = rows.Add(position);
  WriteRows(index.positions(leaf), index.normals(leaf), rows.row(first));
  return first;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_ROWS_POINT_ROWS_INL_H_
