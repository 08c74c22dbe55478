// Triangles with random corners in a neighborhood (Lachaud et al. 2023, section 4: uniform and independent).

#if defined(CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_TRIANGLES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_TRIANGLES_INL_H_
#undef CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_TRIANGLES_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_TRIANGLES_INL_H_
#endif

#include <algorithm>

#include "core/estimators/frames.h"
#include "core/estimators/group_scratch.h"
#include "core/estimators/measures-inl.h"
#include "core/estimators/neighbors.h"
#include "core/estimators/triangles/random_stream.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Mean area of triangles with random corners in a disc, in units of rho^2: 35 / (48 pi).
inline constexpr float kUsualTriangleArea = 0.232f;

// Corner indices of one vector of triangles.
struct CornerIndices {
  alignas(64) int32_t corner[3][SpatialIndex::kLeafSize];
};

// Three distinct ones of `count` indices.
HWY_INLINE void DrawDistinct(RandomStream& random, uint32_t count, const uint32_t* indices, int lane,
                             CornerIndices& out) {
  const uint64_t bits = random.Next();
  const uint32_t a = Draw21(bits, count);
  uint32_t b = Draw21(bits >> 21, count - 1);
  b += b >= a;
  uint32_t c = Draw21(bits >> 42, count - 2);
  c += c >= std::min(a, b);
  c += c >= std::max(a, b);
  out.corner[0][lane] = static_cast<int32_t>(indices[a]);
  out.corner[1][lane] = static_cast<int32_t>(indices[b]);
  out.corner[2][lane] = static_cast<int32_t>(indices[c]);
}

// Elements of `array` by index. In the first kVectors vectors of it, permutations find them faster than loads lane by
// lane; anywhere in it for kVectors = 0.
template <int kVectors>
HWY_INLINE FloatVec LookUp(const float* array, hn::Vec<IntTag> index) {
  const FloatTag d;
  if constexpr (kVectors == 0) {
    return hn::GatherIndex(d, array, index);
  } else {
    const IntTag di;
    const auto last_lane = hn::Set(di, static_cast<int32_t>(hn::Lanes(d)) - 1);
    const auto lane = hn::IndicesFromVec(d, hn::And(index, last_lane));
    const FloatVec first = hn::TableLookupLanes(hn::Load(d, array), lane);
    if constexpr (kVectors == 1) return first;
    const FloatVec second = hn::TableLookupLanes(hn::Load(d, array + hn::Lanes(d)), lane);
    return hn::IfThenElse(hn::RebindMask(d, hn::Gt(index, last_lane)), second, first);
  }
}

// Adds the measures of a vector of triangles over the neighbors of point i, which are within kVectors vectors.
template <int kVectors>
HWY_INLINE void AddIndexedTriangles(const GroupScratch& s, const NeighborArrays& n, size_t i,
                                    const CornerIndices& indices, FloatMask used, Measures& sum) {
  const FloatTag d;
  const IntTag di;
  const Frame frame{Broadcast(s.frames.u, i), Broadcast(s.frames.v, i)};
  const Triple own = Broadcast(s.points.normal, i);
  const FloatVec unit = hn::Set(d, 1.0f / s.frames.rho[i]);
  Corner corners[3];
  for (int c = 0; c < 3; ++c) {
    const auto index = hn::Load(di, indices.corner[c]);
    const Triple offset{LookUp<kVectors>(n.dx.data(), index), LookUp<kVectors>(n.dy.data(), index),
                        LookUp<kVectors>(n.dz.data(), index)};
    const Triple normal{LookUp<kVectors>(n.nx.data(), index), LookUp<kVectors>(n.ny.data(), index),
                        LookUp<kVectors>(n.nz.data(), index)};
    corners[c] = {Scale(offset, unit), Sub(normal, own)};
  }
  Measures added = ZeroMeasures();
  AddTriangle(frame, own, corners, added);
  sum.area = hn::Add(sum.area, hn::IfThenElseZero(used, added.area));
  sum.mean = hn::Add(sum.mean, hn::IfThenElseZero(used, added.mean));
  sum.gaussian = hn::Add(sum.gaussian, hn::IfThenElseZero(used, added.gaussian));
  sum.tensor_uu = hn::Add(sum.tensor_uu, hn::IfThenElseZero(used, added.tensor_uu));
  sum.tensor_uv = hn::Add(sum.tensor_uv, hn::IfThenElseZero(used, added.tensor_uv));
  sum.tensor_vv = hn::Add(sum.tensor_vv, hn::IfThenElseZero(used, added.tensor_vv));
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

template <int kVectors, typename DrawCorners>
HWY_INLINE void MeasureTrianglesIn(const NeighborArrays& neighbors, size_t i, size_t triangles, DrawCorners draw,
                                   MeasuringScratch& s) {
  const FloatTag d;
  Measures sum = ZeroMeasures();
  for (size_t t = 0; t < triangles; t += hn::Lanes(d)) {
    CornerIndices indices{};
    const size_t lanes = std::min(hn::Lanes(d), triangles - t);
    for (size_t lane = 0; lane < lanes; ++lane) draw(static_cast<int>(lane), indices);
    AddIndexedTriangles<kVectors>(s, neighbors, i, indices, hn::FirstN(d, lanes), sum);
  }
  StoreMeanMeasures(sum, triangles, i, s.measures);
}

// Measures `triangles` triangles over the neighbors of point i, whose corners `draw(lane, indices)` gives.
template <typename DrawCorners>
HWY_INLINE void MeasureTriangles(const NeighborArrays& neighbors, size_t i, size_t triangles, DrawCorners draw,
                                 MeasuringScratch& s) {
  const size_t lanes = hn::Lanes(FloatTag());
  if (neighbors.count <= lanes) {
    MeasureTrianglesIn<1>(neighbors, i, triangles, draw, s);
  } else if (neighbors.count <= 2 * lanes) {
    MeasureTrianglesIn<2>(neighbors, i, triangles, draw, s);
  } else {
    MeasureTrianglesIn<0>(neighbors, i, triangles, draw, s);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_TRIANGLES_INL_H_
