// Visitors of GroupSearch (core/search/group_search-inl.h): what estimators take of the neighbors of a query.

#if defined(CURVD_CORE_ESTIMATORS_NEIGHBORS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_NEIGHBORS_INL_H_
#undef CURVD_CORE_ESTIMATORS_NEIGHBORS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_NEIGHBORS_INL_H_
#endif

#include <algorithm>

#include "core/estimators/neighbors.h"
#include "core/search/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

HWY_INLINE void StoreSums(FloatVec x, FloatVec y, FloatVec z, float* sums) {
  float four[4];
  StoreFourSums(x, y, z, hn::Zero(FloatTag()), four);
  std::copy(four, four + 3, sums);
}

// Sums the neighbors' normals into sum[0..2].
class NormalSummer {
 public:
  NormalSummer(const SpatialIndex& index, float* sum) : index_(&index), sum_(sum) { Start(0); }

  HWY_INLINE void Start(size_t) { x_ = y_ = z_ = hn::Zero(FloatTag()); }
  HWY_INLINE void operator()(const NearPoints& points, FloatMask inside) {
    const FloatTag d;
    const SpatialIndex::LeafNormals& normals = index_->normals(points.leaf);
    x_ = AddWhere(inside, x_, hn::Load(d, normals.x + points.place));
    y_ = AddWhere(inside, y_, hn::Load(d, normals.y + points.place));
    z_ = AddWhere(inside, z_, hn::Load(d, normals.z + points.place));
  }
  HWY_INLINE void Finish() { StoreSums(x_, y_, z_, sum_); }

 private:
  const SpatialIndex* index_;
  float* sum_;
  FloatVec x_, y_, z_;
};

// Collects the neighbors of query[0..2], and sums their normals into sum[0..2].
class NeighborCollector {
 public:
  NeighborCollector(const SpatialIndex& index, const float* query, NeighborArrays& neighbors, float* sum)
      : index_(&index), query_(query), neighbors_(&neighbors), sum_(sum) {}

  HWY_INLINE void Start(size_t count) {
    neighbors_->Reserve(count);
    dx_ = neighbors_->dx.data(), dy_ = neighbors_->dy.data(), dz_ = neighbors_->dz.data();
    nx_ = neighbors_->nx.data(), ny_ = neighbors_->ny.data(), nz_ = neighbors_->nz.data();
    count_ = 0;
  }
  HWY_INLINE void operator()(const NearPoints& near, FloatMask inside) {
    const FloatTag d;
    const size_t kept = hn::CountTrue(d, inside);
    if (kept == 0) return;
    const SpatialIndex::LeafPositions& points = index_->positions(near.leaf);
    const SpatialIndex::LeafNormals& normals = index_->normals(near.leaf);
    const QueryVectors q(query_);
    const size_t i = near.place;
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.x + i), q.x), inside), d, dx_ + count_);
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.y + i), q.y), inside), d, dy_ + count_);
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.z + i), q.z), inside), d, dz_ + count_);
    hn::StoreU(hn::Compress(hn::Load(d, normals.x + i), inside), d, nx_ + count_);
    hn::StoreU(hn::Compress(hn::Load(d, normals.y + i), inside), d, ny_ + count_);
    hn::StoreU(hn::Compress(hn::Load(d, normals.z + i), inside), d, nz_ + count_);
    count_ += kept;
  }
  HWY_INLINE void Finish() {
    const FloatTag d;
    for (float* array : {dx_, dy_, dz_, nx_, ny_, nz_}) hn::StoreU(hn::Zero(d), d, array + count_);
    neighbors_->count = count_;
    FloatVec x = hn::Zero(d), y = hn::Zero(d), z = hn::Zero(d);
    for (size_t j = 0; j < count_; j += hn::Lanes(d)) {
      x = hn::Add(x, hn::Load(d, nx_ + j));
      y = hn::Add(y, hn::Load(d, ny_ + j));
      z = hn::Add(z, hn::Load(d, nz_ + j));
    }
    StoreSums(x, y, z, sum_);
  }

 private:
  const SpatialIndex* index_;
  const float* query_;
  NeighborArrays* neighbors_;
  float* sum_;
  float *dx_ = nullptr, *dy_ = nullptr, *dz_ = nullptr, *nx_ = nullptr, *ny_ = nullptr, *nz_ = nullptr;
  size_t count_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_NEIGHBORS_INL_H_
