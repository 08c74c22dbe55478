// Corrected measures of the umbrella triangles in a neighborhood (Lachaud et al. 2023, section 4: CNC-Delaunay).
//
// A triangle's measures depend on no query: those near a group are measured once, and each query sums eight floats for
// each triangle around it.

#if defined(CURVD_CORE_ESTIMATORS_DELAUNAY_UMBRELLA_TRIANGLES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_DELAUNAY_UMBRELLA_TRIANGLES_INL_H_
#undef CURVD_CORE_ESTIMATORS_DELAUNAY_UMBRELLA_TRIANGLES_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_DELAUNAY_UMBRELLA_TRIANGLES_INL_H_
#endif

#include <algorithm>
#include <bit>

#include "core/estimators/delaunay/delaunay_scratch.h"
#include "core/estimators/delaunay/umbrella_triangles.h"
#include "core/estimators/fits/double_sums-inl.h"
#include "core/estimators/measures-inl.h"
#include "core/estimators/rows/quads-inl.h"
#include "core/search/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// All of a triangle's measures, a vector or parts of it.
using MeasuresTag = hn::CappedTag<double, sizeof(TriangleMeasures) / sizeof(double)>;

// A corner of each of a vector of triangles.
struct CornerBatch {
  Triple position, normal;
  hn::Vec<IntTag> rank, place;
};

// Makes measures, floats of any size, numbers whose sums do not depend on the order: as Odd
// (core/estimators/fits/double_sums-inl.h), but for 0, which stays.
HWY_INLINE void MakeOdd(const float (&from)[8], double (&to)[8]) {
  // A row comes in halves, which are best read as they were written.
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> floats;
  const hn::RebindToUnsigned<decltype(d)> bits;
  for (size_t i = 0; i < 8; i += hn::Lanes(d)) {
    const auto v = hn::PromoteTo(d, hn::Load(floats, from + i));
    const auto odd = hn::BitCast(d, hn::Or(hn::BitCast(bits, v), hn::Set(bits, 1)));
    hn::Store(hn::IfThenElseZero(hn::Ne(v, hn::Zero(d)), odd), d, to + i);
  }
}

// Measures a vector of triangles that count `weights`; a row of `measures`, in the order of TriangleMeasures, each. As
// in measures-inl.h, with the whole tensor: half the symmetric part of (e2 x w) (x) n1 - (e1 x w) (x) n2.
HWY_INLINE void MeasureBatch(const CornerBatch* corners, FloatVec weights, float (*measures)[8]) {
  const FloatTag d;
  const Triple &u0 = corners[0].normal, &u1 = corners[1].normal, &u2 = corners[2].normal;
  const Triple e1 = Sub(corners[1].position, corners[0].position), e2 = Sub(corners[2].position, corners[0].position);
  const Triple n1 = Sub(u1, u0), n2 = Sub(u2, u0);
  const Triple w = Scale(Add(Add(u0, u1), u2), hn::Set(d, 1.0f / 3.0f));
  const Triple e1_w = Cross(e1, w), e2_w = Cross(e2, w);
  const FloatVec twice_area = Dot(e1, e2_w);
  const FloatVec half = hn::CopySign(hn::Mul(weights, hn::Set(d, 0.5f)), twice_area);
  const FloatVec quarter = hn::Mul(half, hn::Set(d, 0.5f));
  const auto diagonal = [&](FloatVec p, FloatVec q, FloatVec m1, FloatVec m2)
                            HWY_ATTR { return hn::Mul(half, hn::NegMulAdd(q, m2, hn::Mul(p, m1))); };
  const auto mixed = [&](FloatVec pa, FloatVec pb, FloatVec qa, FloatVec qb, FloatVec m1a, FloatVec m1b, FloatVec m2a,
                         FloatVec m2b) HWY_ATTR {
    const FloatVec ab = hn::NegMulAdd(qa, m2b, hn::Mul(pa, m1b));
    const FloatVec ba = hn::NegMulAdd(qb, m2a, hn::Mul(pb, m1a));
    return hn::Mul(quarter, hn::Add(ab, ba));
  };
  const Triple &p = e2_w, &q = e1_w;
  const Quads<FloatTag> first{diagonal(p.x, q.x, n1.x, n2.x), diagonal(p.y, q.y, n1.y, n2.y),
                              diagonal(p.z, q.z, n1.z, n2.z), mixed(p.x, p.y, q.x, q.y, n1.x, n1.y, n2.x, n2.y)};
  const Quads<FloatTag> last{mixed(p.y, p.z, q.y, q.z, n1.y, n1.z, n2.y, n2.z),
                             mixed(p.z, p.x, q.z, q.x, n1.z, n1.x, n2.z, n2.x), hn::Mul(half, twice_area),
                             hn::Mul(half, Dot(u0, Cross(n1, n2)))};
  StoreQuads(first, d, [measures](size_t lane) HWY_ATTR { return measures[lane]; });
  StoreQuads(last, d, [measures](size_t lane) HWY_ATTR { return measures[lane] + 4; });
}

// Exchanges two corners of the triangles that have them in the other order than that of their ranks.
HWY_INLINE void OrderTwoCorners(CornerBatch& a, CornerBatch& b) {
  const FloatTag d;
  const auto late = hn::Lt(b.rank, a.rank);
  const auto late_floats = hn::RebindMask(d, late);
  const auto exchange = [](auto mask, auto& first, auto& second) HWY_ATTR {
    const auto lower = hn::IfThenElse(mask, second, first);
    second = hn::IfThenElse(mask, first, second);
    first = lower;
  };
  exchange(late, a.rank, b.rank);
  exchange(late, a.place, b.place);
  for (FloatVec Triple::*component : {&Triple::x, &Triple::y, &Triple::z}) {
    exchange(late_floats, a.position.*component, b.position.*component);
    exchange(late_floats, a.normal.*component, b.normal.*component);
  }
}

// Measures all gathered triangles, with their corners in the order of their ranks, so that what is computed of a
// triangle does not depend on whose umbrella it was taken from. Leaves the corners in that order.
HWY_INLINE void MeasureGathered(UmbrellaTriangles& triangles) {
  const FloatTag d;
  const IntTag di;
  const size_t size = triangles.size();
  alignas(64) float measures[SpatialIndex::kLeafSize][8];
  for (size_t t = 0; t < size; t += hn::Lanes(d)) {
    UmbrellaTriangles::Triangle* const batch = triangles.mutable_triangles() + t;
    const auto row = [batch](size_t lane) HWY_ATTR { return reinterpret_cast<int32_t*>(&batch[lane]); };
    const Quads<IntTag> rows = LoadQuads(di, row);
    CornerBatch corners[3];
    for (int c = 0; c < 3; ++c) {
      const auto at = [&](size_t lane) HWY_ATTR { return triangles.corners()[batch[lane].place[c]].position; };
      const auto normal_at = [&](size_t lane) HWY_ATTR { return triangles.corners()[batch[lane].place[c]].normal; };
      const Quads<FloatTag> position = LoadQuads(d, at), normal = LoadQuads(d, normal_at);
      corners[c] = {{position.x, position.y, position.z},
                    {normal.x, normal.y, normal.z},
                    hn::BitCast(di, position.w),
                    c == 0   ? rows.x
                    : c == 1 ? rows.y
                             : rows.z};
    }
    OrderTwoCorners(corners[0], corners[1]);
    OrderTwoCorners(corners[1], corners[2]);
    OrderTwoCorners(corners[0], corners[1]);
    StoreQuads({corners[0].place, corners[1].place, corners[2].place, rows.w}, di, row);
    MeasureBatch(corners, hn::Mul(hn::ConvertTo(d, rows.w), hn::Set(d, 1.0f / 3.0f)), measures);
    const size_t lanes = std::min(hn::Lanes(d), size - t);
    for (size_t lane = 0; lane < lanes; ++lane) MakeOdd(measures[lane], triangles.measures()[t + lane].values);
  }
}

HWY_INLINE void LoadCorners(const SpatialIndex& index, const LeafList& leaves, UmbrellaTriangles& triangles) {
  const FloatTag d;
  const IntTag di;
  constexpr size_t kLeaf = SpatialIndex::kLeafSize;
  for (size_t j = 0; j < leaves.size(); ++j) {
    const SpatialIndex::LeafPositions& points = index.positions(leaves.leaf(j));
    const SpatialIndex::LeafNormals& normals = index.normals(leaves.leaf(j));
    for (size_t i = 0; i < kLeaf; i += hn::Lanes(d)) {
      TriangleCorner* const corners = triangles.corners() + j * kLeaf + i;
      const Quads<FloatTag> position{hn::Load(d, points.x + i), hn::Load(d, points.y + i), hn::Load(d, points.z + i),
                                     hn::BitCast(d, hn::Load(di, points.id + i))};
      const Quads<FloatTag> normal{hn::Load(d, normals.x + i), hn::Load(d, normals.y + i), hn::Load(d, normals.z + i),
                                   hn::Zero(d)};
      StoreQuads(position, d, [corners](size_t lane) HWY_ATTR { return corners[lane].position; });
      StoreQuads(normal, d, [corners](size_t lane) HWY_ATTR { return corners[lane].normal; });
    }
  }
}

// Sets the weight of each neighbor as a corner: 1/3 at the point, less by `falloff` of it at the squared radius. Lists
// the positions of the leaves with neighbors; returns their number.
HWY_INLINE size_t WeighNeighbors(const SpatialIndex& index, const Neighborhood& found, float squared_radius,
                                 float falloff, UmbrellaTriangles& triangles, ScratchArray<uint32_t>& positions) {
  const FloatTag d;
  constexpr size_t kLeaf = SpatialIndex::kLeafSize;
  const FloatVec third = hn::Set(d, 1.0f / 3.0f), loss = hn::Set(d, falloff / 3.0f);
  const FloatVec rim = hn::Set(d, squared_radius);
  const FloatVec none = hn::Set(d, UmbrellaTriangles::kNoNeighbor);
  positions.Reserve(found.leaf_count);
  float* weights = triangles.weights();
  uint32_t* listed = positions.data();
  size_t count = 0;
  const auto weigh = [&](const NearPoints& near, FloatMask inside) CURVD_INLINED {
    const FloatTag tag;
    if (hn::AllFalse(tag, inside)) return;
    const uint32_t position = near.position;
    const FloatVec weight = hn::NegMulAdd(hn::Div(near.squared, rim), loss, third);
    hn::Store(hn::IfThenElse(inside, weight, none), tag, weights + position * kLeaf + near.place);
    if (count == 0 || listed[count - 1] != position) listed[count++] = position;
  };
  ForEachInside(index, found, weigh);
  return count;
}

// Where the sums of the measures of at most `count` triangles begin, whose corners lie within rho of each other's
// middle, so that each is exact in its quanta (core/estimators/fits/double_sums-inl.h). Corners weigh at most 1
// together, edges are at most 2 rho long, and normals differ by at most 2.
HWY_INLINE TriangleMeasures MeasureAnchors(size_t count, float rho) {
  const double above_rho = 2.0 * static_cast<double>(std::bit_cast<float>(std::bit_cast<uint32_t>(rho) & 0xFF800000u));
  const double anchor = 3.0 * static_cast<double>(std::bit_ceil(4 * count));
  TriangleMeasures anchors;
  std::fill_n(anchors.values, 6, anchor * above_rho);
  anchors.values[6] = anchor * above_rho * above_rho;
  anchors.values[7] = anchor;
  return anchors;
}

// Sums the weighted measures of all triangles whose corners are neighbors, at distances up to rho, in whatever order
// they come. Adds to `work` a step for each triangle that it looks at.
HWY_INLINE TriangleMeasures SumNeighborTriangles(const UmbrellaTriangles& triangles, const uint32_t* positions,
                                                 size_t count, size_t neighbor_count, float rho, uint64_t& work) {
  const MeasuresTag d;
  constexpr size_t kParts = sizeof(TriangleMeasures) / sizeof(double) / hn::MaxLanes(MeasuresTag());
  const float* weights = triangles.weights();
  const TriangleMeasures anchors = MeasureAnchors(neighbor_count * Umbrella::kMaxTriangles, rho);
  hn::Vec<MeasuresTag> anchor[kParts], even[kParts], odd[kParts];
  for (size_t part = 0; part < kParts; ++part) {
    anchor[part] = even[part] = odd[part] = hn::Load(d, anchors.values + part * hn::MaxLanes(d));
  }
  const auto add = [&](uint32_t t, hn::Vec<MeasuresTag>* sum) HWY_ATTR {
    const uint32_t* place = triangles.triangle(t).place;
    // The mean of the corners' weights over the triangle; nothing where one is no neighbor.
    const float mean = weights[place[0]] + weights[place[1]] + weights[place[2]];
    // In vectors: compilers make a branch of a scalar's maximum, which nobody can predict.
    const auto weight = hn::Max(hn::Set(d, static_cast<double>(mean)), hn::Zero(d));
    const double* measures = triangles.measures()[t].values;
    for (size_t part = 0; part < kParts; ++part) {
      sum[part] = AddProduct(hn::Load(d, measures + part * hn::MaxLanes(d)), weight, sum[part], anchor[part]);
    }
  };
  size_t looked_at = 0;
  for (size_t j = 0; j < count; ++j) {
    uint32_t t = triangles.first(positions[j]);
    const uint32_t last = triangles.first(positions[j] + 1);
    looked_at += last - t;
    // Two sums, since an addition waits for the one before it.
    for (; t + 1 < last; t += 2) {
      add(t, even);
      add(t + 1, odd);
    }
    if (t < last) add(t, even);
  }
  work += looked_at;
  TriangleMeasures measures;
  for (size_t part = 0; part < kParts; ++part) {
    const auto total = hn::Add(hn::Sub(even[part], anchor[part]), hn::Sub(odd[part], anchor[part]));
    hn::Store(total, d, measures.values + part * hn::MaxLanes(d));
  }
  return measures;
}

// By how much to stretch the tensor in the tangent plane of a point: triangles tilt against it, by which their tensors
// lose the part k^3 s^2 of each principal curvature k, s^2 = `spread` being the mean square of the triangles' distance
// along either axis (docs/numerics.md). All in units of rho.
HWY_INLINE float TiltFactor(float spread, float mean, float half_difference_squared) {
  constexpr float kMost = 0.25f;  // where normals turn farther than this, the next terms matter as much
  return 1.0f + std::min(spread * (3.0f * mean * mean + half_difference_squared), kMost);
}

// The measures of point i, of lengths in units of rho, with the tensor in its tangent frame.
HWY_INLINE void StoreMeasures(const TriangleMeasures& m, float spread, const GroupFrames& frames, size_t i,
                              GroupMeasures& out) {
  float u[3], v[3];
  frames.u.Get(i, u);
  frames.v.Get(i, v);
  const auto tensor = [&m](const float* a, const float* c) {
    return m.xx() * a[0] * c[0] + m.yy() * a[1] * c[1] + m.zz() * a[2] * c[2] + m.xy() * (a[0] * c[1] + a[1] * c[0]) +
           m.yz() * (a[1] * c[2] + a[2] * c[1]) + m.zx() * (a[2] * c[0] + a[0] * c[2]);
  };
  const float per_rho = 1.0f / frames.rho[i];
  const float area = m.area() * per_rho * per_rho, mean = 0.5f * (m.xx() + m.yy() + m.zz()) * per_rho;
  const float uu = tensor(u, u) * per_rho, uv = tensor(u, v) * per_rho, vv = tensor(v, v) * per_rho;
  const float difference = 0.5f * (uu - vv);
  const float tilt = TiltFactor(spread, mean / area, (difference * difference + uv * uv) / (area * area));
  out.area[i] = area;
  out.mean[i] = mean;
  out.gaussian[i] = m.gaussian();
  out.tensor_uu[i] = uu * tilt;
  out.tensor_uv[i] = uv * tilt;
  out.tensor_vv[i] = vv * tilt;
}

// Measures the umbrella triangles around point i, whose neighbors were just found in `leaves`.
HWY_NOINLINE inline void MeasureUmbrellas(const SpatialIndex& index, const DelaunayPlan& plan, const LeafList& leaves,
                                          size_t i, DelaunayScratch& s) {
  if (s.triangles.Gather(index, plan.umbrellas, leaves)) {
    LoadCorners(index, leaves, s.triangles);
    MeasureGathered(s.triangles);
    s.search.work += leaves.size() * SpatialIndex::kLeafSize + s.triangles.lookups() + s.triangles.size();
  }
  const float rho = s.frames.rho[i];
  const size_t count = WeighNeighbors(index, s.search.found, rho * rho, plan.falloff, s.triangles, s.positions);
  const TriangleMeasures sum =
      SumNeighborTriangles(s.triangles, s.positions.data(), count, s.search.found.count, rho, s.search.work);
  StoreMeasures(sum, plan.spread, s.frames, i, s.measures);
  constexpr size_t kLeaf = SpatialIndex::kLeafSize;
  for (size_t j = 0; j < count; ++j) {
    std::fill_n(s.triangles.weights() + s.positions[j] * kLeaf, kLeaf, UmbrellaTriangles::kNoNeighbor);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_DELAUNAY_UMBRELLA_TRIANGLES_INL_H_
