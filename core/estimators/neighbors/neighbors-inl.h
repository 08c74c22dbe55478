// Visitors of GroupSearch (core/search/group_search-inl.h): what estimators take of the neighbors of a query.

#if defined(CURVD_CORE_ESTIMATORS_NEIGHBORS_NEIGHBORS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_NEIGHBORS_NEIGHBORS_INL_H_
#undef CURVD_CORE_ESTIMATORS_NEIGHBORS_NEIGHBORS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_NEIGHBORS_NEIGHBORS_INL_H_
#endif

#include <algorithm>

#include "core/estimators/fixed_point-inl.h"
#include "core/estimators/neighbors/neighbors.h"
#include "core/search/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Compares normals with that of a query, a vector of them at a time.
class NormalComparer {
 public:
  HWY_INLINE NormalComparer() { x_ = y_ = z_ = least_ = hn::Zero(FloatTag()); }
  HWY_INLINE void Start(const QueryPoint& query) {
    const FloatTag d;
    x_ = hn::Set(d, query.normal[0]), y_ = hn::Set(d, query.normal[1]), z_ = hn::Set(d, query.normal[2]);
    least_ = hn::Set(d, 1.0f);
  }
  // Cosines, where all vectors have unit length.
  HWY_INLINE FloatVec Agreement(FloatVec x, FloatVec y, FloatVec z) const {
    return hn::MulAdd(z, z_, hn::MulAdd(y, y_, hn::Mul(x, x_)));
  }
  HWY_INLINE void AddWhere(FloatMask mask, FloatVec agreement) {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
    least_ = hn::IfThenElse(mask, hn::Min(least_, agreement), least_);  // one masked instruction
#else
    least_ = hn::Min(least_, hn::IfThenElse(mask, agreement, least_));
#endif
  }
  // At most 1.
  HWY_INLINE float Least() const { return hn::GetLane(hn::MinOfLanes(FloatTag(), least_)); }

 private:
  FloatVec x_, y_, z_, least_;
};

// Sums the normals of the neighbors of `query`, and compares them with its own.
class NormalSummer {
 public:
  // `query` is that of the moment, whenever the search shows neighbors.
  NormalSummer(const SpatialIndex& index, const QueryPoint& query, NormalSums& sums)
      : index_(&index), query_(&query), sums_(&sums) {}

  HWY_INLINE void Start(size_t count) {
    count_ = count;
    total_.Start(count);
    comparer_.Start(*query_);
  }
  HWY_INLINE void operator()(const NearPoints& points, FloatMask inside) {
    const FloatTag d;
    const SpatialIndex::LeafNormals& normals = index_->normals(points.leaf);
    const FloatVec x = hn::Load(d, normals.x + points.place);
    const FloatVec y = hn::Load(d, normals.y + points.place);
    const FloatVec z = hn::Load(d, normals.z + points.place);
    total_.AddWhere(inside, x, y, z);
    comparer_.AddWhere(inside, comparer_.Agreement(x, y, z));
  }
  HWY_INLINE void Finish() {
    total_.Store(count_, sums_->sum);
    sums_->least_agreement = comparer_.Least();
  }

 private:
  const SpatialIndex* index_;
  const QueryPoint* query_;
  NormalSums* sums_;
  size_t count_ = 0;
  UnitVectorSums total_;
  NormalComparer comparer_;
};

// Collects the neighbors of `query`, sums their normals, and compares them with its own.
class NeighborCollector {
 public:
  // `query` is that of the moment, whenever the search shows neighbors. With `of_halves`, which the index has then,
  // normals are those of halves.
  NeighborCollector(const SpatialIndex& index, const QueryPoint& query, NeighborArrays& neighbors, NormalSums& sums,
                    bool of_halves = false)
      : index_(&index),
        normals_(of_halves ? &index.half_normals(0) : &index.normals(0)),
        query_(&query),
        neighbors_(&neighbors),
        sums_(&sums) {}

  HWY_INLINE void Start(size_t count) {
    neighbors_->Reserve(count);
    dx_ = neighbors_->dx.data(), dy_ = neighbors_->dy.data(), dz_ = neighbors_->dz.data();
    nx_ = neighbors_->nx.data(), ny_ = neighbors_->ny.data(), nz_ = neighbors_->nz.data();
    count_ = 0;
  }
  HWY_INLINE void operator()(const NearPoints& near, FloatMask inside) {
    const FloatTag d;
    // Without a branch: whether there are any is what no branch predictor knows.
    const SpatialIndex::LeafPositions& points = index_->positions(near.leaf);
    const SpatialIndex::LeafNormals& normals = normals_[near.leaf];
    const QueryVectors q(query_->position);
    const size_t i = near.place;
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.x + i), q.x), inside), d, dx_ + count_);
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.y + i), q.y), inside), d, dy_ + count_);
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.z + i), q.z), inside), d, dz_ + count_);
    hn::StoreU(hn::Compress(hn::Load(d, normals.x + i), inside), d, nx_ + count_);
    hn::StoreU(hn::Compress(hn::Load(d, normals.y + i), inside), d, ny_ + count_);
    hn::StoreU(hn::Compress(hn::Load(d, normals.z + i), inside), d, nz_ + count_);
    count_ += hn::CountTrue(d, inside);
  }
  HWY_INLINE void Finish() {
    const FloatTag d;
    for (float* array : {dx_, dy_, dz_, nx_, ny_, nz_}) hn::StoreU(hn::Zero(d), d, array + count_);
    neighbors_->count = count_;
    UnitVectorSums total;
    total.Start(count_);
    NormalComparer comparer;
    comparer.Start(*query_);
    size_t added = 0;  // with the padding
    for (size_t j = 0; j < count_; j += hn::Lanes(d)) {
      const FloatVec nx = hn::Load(d, nx_ + j), ny = hn::Load(d, ny_ + j), nz = hn::Load(d, nz_ + j);
      total.Add(nx, ny, nz);
      added += hn::Lanes(d);
      comparer.AddWhere(hn::FirstN(d, count_ - j), comparer.Agreement(nx, ny, nz));
    }
    total.Store(added, sums_->sum);
    sums_->least_agreement = comparer.Least();
  }

 private:
  const SpatialIndex* index_;
  const SpatialIndex::LeafNormals* normals_;  // of all leaves
  const QueryPoint* query_;
  NeighborArrays* neighbors_;
  NormalSums* sums_;
  float *dx_ = nullptr, *dy_ = nullptr, *dz_ = nullptr, *nx_ = nullptr, *ny_ = nullptr, *nz_ = nullptr;
  size_t count_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_NEIGHBORS_NEIGHBORS_INL_H_
