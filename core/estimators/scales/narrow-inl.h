// Finds the neighbors at each scale among those of the next larger one, without another search.

#if defined(CURVD_CORE_ESTIMATORS_SCALES_NARROW_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_SCALES_NARROW_INL_H_
#undef CURVD_CORE_ESTIMATORS_SCALES_NARROW_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_SCALES_NARROW_INL_H_
#endif

#include <algorithm>
#include <limits>

#include "core/estimators/fixed_point-inl.h"
#include "core/estimators/neighbors-inl.h"
#include "core/estimators/scales/ring_neighbors.h"
#include "core/search/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Ends the arrays after `count` neighbors.
HWY_INLINE void EndRing(size_t count, RingNeighbors& ring) {
  const FloatTag d;
  NeighborArrays& n = ring.neighbors;
  n.count = count;
  for (auto* array : {&n.dx, &n.dy, &n.dz, &n.nx, &n.ny, &n.nz}) hn::StoreU(hn::Zero(d), d, array->data() + count);
  hn::StoreU(hn::Set(d, std::numeric_limits<float>::infinity()), d, ring.squared.data() + count);
}

// Collects the neighbors of `query` at the largest scale, sums their normals, and compares them with its own: a visitor
// of GroupSearch.
class RingCollector {
 public:
  // `query` is that of the moment, whenever the search shows neighbors.
  RingCollector(const SpatialIndex& index, const QueryPoint& query, RingNeighbors& ring, NormalSums& sums)
      : index_(&index), query_(&query), ring_(&ring), sums_(&sums) {}

  HWY_INLINE void Start(size_t count) {
    ring_->Reserve(count);
    total_.Start(count);
    comparer_.Start(*query_);
    count_ = 0;
  }
  HWY_INLINE void operator()(const NearPoints& near, FloatMask inside) {
    const FloatTag d;
    const IntTag di;
    const size_t kept = hn::CountTrue(d, inside);
    if (kept == 0) return;
    const SpatialIndex::LeafPositions& points = index_->positions(near.leaf);
    const SpatialIndex::LeafNormals& normals = index_->normals(near.leaf);
    NeighborArrays& n = ring_->neighbors;
    const QueryVectors q(query_->position);
    const size_t i = near.place;
    const FloatVec nx = hn::Load(d, normals.x + i), ny = hn::Load(d, normals.y + i), nz = hn::Load(d, normals.z + i);
    const auto keep = [&](FloatVec v, ScratchArray<float>& array)
                          HWY_ATTR { hn::StoreU(hn::Compress(v, inside), d, array.data() + count_); };
    keep(hn::Sub(hn::Load(d, points.x + i), q.x), n.dx);
    keep(hn::Sub(hn::Load(d, points.y + i), q.y), n.dy);
    keep(hn::Sub(hn::Load(d, points.z + i), q.z), n.dz);
    keep(nx, n.nx);
    keep(ny, n.ny);
    keep(nz, n.nz);
    keep(near.squared, ring_->squared);
    const auto ids = hn::Compress(hn::Load(di, points.id + i), hn::RebindMask(di, inside));
    hn::StoreU(ids, di, ring_->id.data() + count_);
    hn::StoreU(IntsFrom(static_cast<int32_t>(count_)), di, ring_->number.data() + count_);
    total_.AddWhere(inside, nx, ny, nz);
    comparer_.AddWhere(inside, comparer_.Agreement(nx, ny, nz));
    count_ += kept;
  }
  HWY_INLINE void Finish() {
    EndRing(count_, *ring_);
    total_.Store(count_, sums_->sum);
    sums_->least_agreement = comparer_.Least();
  }

 private:
  const SpatialIndex* index_;
  const QueryPoint* query_;
  RingNeighbors* ring_;
  NormalSums* sums_;
  size_t count_ = 0;
  UnitVectorSums total_;
  NormalComparer comparer_;
};

// The rank of the k-th of the neighbors, of whom more than k are within a limit: ties go to the lowest ids.
HWY_NOINLINE inline NeighborRank SplitRingTies(const CountedLimit& counted, size_t k, RingNeighbors& ring) {
  ring.tied.Reserve(counted.count - counted.below);
  int32_t* end = ring.tied.data();
  for (size_t j = 0; j < ring.neighbors.count; ++j) {
    if (ring.squared[j] == counted.limit) *end++ = ring.id[ring.number[j]];
  }
  int32_t* last = ring.tied.data() + (k - counted.below - 1);
  std::nth_element(ring.tied.data(), last, end);
  return {counted.limit, *last};
}

// The rank of the k-th of the neighbors, all of which are within a squared radius. Its id is SpatialIndex::kPaddingId
// where none at its distance is left out.
HWY_INLINE NeighborRank LastOf(size_t k, float squared_radius, RingNeighbors& ring) {
  const CountedLimit counted = LimitByCounting(ring.squared.data(), ring.neighbors.count, k, squared_radius);
  if (counted.count == k) return {counted.limit, SpatialIndex::kPaddingId};
  return SplitRingTies(counted, k, ring);
}

// Keeps the neighbors of at most the rank `last`, which are `count`, sums their normals, and compares them with that of
// `query`. Returns the largest squared distance of one. Everything is what a search for them alone finds, but for their
// order.
template <bool kSplitsTies>
HWY_INLINE float KeepInside(const NeighborRank& last, size_t count, const QueryPoint& query, RingNeighbors& ring,
                            NormalSums& sums) {
  const FloatTag d;
  const IntTag di;
  NeighborArrays& n = ring.neighbors;
  UnitVectorSums total;
  total.Start(count);
  NormalComparer comparer;
  comparer.Start(query);
  FloatVec farthest = hn::Zero(d);
  size_t kept = 0;
  for (size_t j = 0; j < n.count; j += hn::Lanes(d)) {
    const FloatVec squared = hn::Load(d, ring.squared.data() + j);  // infinity past the last one
    const auto number = hn::Load(di, ring.number.data() + j);
    FloatMask inside;
    if constexpr (kSplitsTies) {
      alignas(64) int32_t ids[hn::MaxLanes(FloatTag())];
      for (size_t lane = 0; lane < hn::Lanes(d); ++lane) {
        ids[lane] = j + lane < n.count ? ring.id[ring.number[j + lane]] : SpatialIndex::kPaddingId;
      }
      inside = Inside<true>(squared, ids, last);
    } else {
      inside = hn::Le(squared, hn::Set(d, last.squared_distance));
    }
    const FloatVec nx = hn::Load(d, n.nx.data() + j), ny = hn::Load(d, n.ny.data() + j),
                   nz = hn::Load(d, n.nz.data() + j);
    farthest = hn::Max(farthest, hn::IfThenElseZero(inside, squared));
    total.AddWhere(inside, nx, ny, nz);
    comparer.AddWhere(inside, comparer.Agreement(nx, ny, nz));
    // What is written was read: as many are kept at most.
    const auto keep = [&](FloatVec v, ScratchArray<float>& array)
                          HWY_ATTR { hn::StoreU(hn::Compress(v, inside), d, array.data() + kept); };
    keep(hn::Load(d, n.dx.data() + j), n.dx);
    keep(hn::Load(d, n.dy.data() + j), n.dy);
    keep(hn::Load(d, n.dz.data() + j), n.dz);
    keep(nx, n.nx);
    keep(ny, n.ny);
    keep(nz, n.nz);
    keep(squared, ring.squared);
    hn::StoreU(hn::Compress(number, hn::RebindMask(di, inside)), di, ring.number.data() + kept);
    kept += hn::CountTrue(d, inside);
  }
  EndRing(kept, ring);
  total.Store(kept, sums.sum);
  sums.least_agreement = comparer.Least();
  return hn::GetLane(hn::MaxOfLanes(d, farthest));
}

// Leaves the k nearest of the neighbors, all of which are within a squared radius, and makes theirs of it. Returns the
// rank of the last one. REQUIRES: there are at least k.
HWY_NOINLINE inline NeighborRank Narrow(size_t k, const QueryPoint& query, RingNeighbors& ring, float& squared_radius,
                                        NormalSums& sums) {
  const NeighborRank last = LastOf(k, squared_radius, ring);
  squared_radius = last.id == SpatialIndex::kPaddingId ? KeepInside<false>(last, k, query, ring, sums)
                                                       : KeepInside<true>(last, k, query, ring, sums);
  return last;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_SCALES_NARROW_INL_H_
