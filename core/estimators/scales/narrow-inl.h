// Finds the neighbors at each scale among those of the next larger one, without another search.

#if defined(CURVD_CORE_ESTIMATORS_SCALES_NARROW_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_SCALES_NARROW_INL_H_
#undef CURVD_CORE_ESTIMATORS_SCALES_NARROW_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_SCALES_NARROW_INL_H_
#endif

#include <limits>

#include "core/search/neighborhood-inl.h"
#include "core/search/search_scratch.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Leaves the leaves with a point within `squared_limit`, and measures as MeasureDistances does how many of their points
// lie nearer than a range of distances, and within it.
HWY_INLINE DistanceCounts KeepLeaves(float squared_limit, const DistanceRange& range, SearchScratch& s) {
  const FloatTag d;
  constexpr size_t kLeaf = SpatialIndex::kLeafSize;
  const FloatVec limit = hn::Set(d, squared_limit), low = hn::Set(d, range.low), high = hn::Set(d, range.high);
  Neighborhood& found = s.found;
  s.inner_distances.Reserve(found.leaf_count * kLeaf + 2 * kLeaf);
  uint32_t* const leaves = found.leaves.data();
  uint32_t* const positions = found.positions.data();
  float* const squared_distances = found.squared_distances.data();
  float* inner = s.inner_distances.data();
  size_t below = 0, kept = 0;
  for (size_t j = 0; j < found.leaf_count; ++j) {
    leaves[kept] = leaves[j];
    positions[kept] = positions[j];
    size_t members = 0;
    for (size_t i = 0; i < kLeaf; i += hn::Lanes(d)) {
      const FloatVec squared = hn::Load(d, squared_distances + j * kLeaf + i);
      hn::Store(squared, d, squared_distances + kept * kLeaf + i);
      members += hn::CountTrue(d, hn::Le(squared, limit));
      const FloatMask is_below = hn::Le(squared, low);
      const FloatMask inside = hn::AndNot(is_below, hn::Le(squared, high));
      below += hn::CountTrue(d, is_below);
      hn::StoreU(hn::Compress(squared, inside), d, inner);
      inner += hn::CountTrue(d, inside);
    }
    // Without a branch: whether there are any is what no branch predictor knows.
    kept += members > 0 ? 1 : 0;
  }
  hn::StoreU(hn::Set(d, std::numeric_limits<float>::infinity()), d, inner);
  s.work += found.leaf_count * kLeaf;
  found.leaf_count = kept;
  return {below, static_cast<size_t>(inner - s.inner_distances.data())};
}

// Narrows the neighborhood that a search has found for a query (SearchScratch::found) to fewer and fewer neighbors:
// each time it becomes what a search for so many finds.
class Narrower {
 public:
  // `next_radius` guesses the squared radius of the neighborhood to come, of about `next_count` neighbors; 0 where
  // nothing is known of it, or none comes. Guesses decide on the time alone.
  Narrower(size_t next_count, float next_radius, SearchScratch& s) : s_(s) { Keep(next_count, next_radius); }

  // Leaves the k nearest neighbors. REQUIRES: k is less than their number; it is the next_count of before.
  HWY_NOINLINE void To(const SpatialIndex& index, size_t k, size_t next_count, float next_radius) {
    if (HWY_UNLIKELY(counts_.below >= k || counts_.below + counts_.inside < k)) {
      range_ = {DistanceRange::kNoLow, s_.found.last.squared_distance};
      counts_ = KeepLeaves(s_.found.last.squared_distance, range_, s_);
    }
    const CountedLimit counted = LimitByCounting(s_.inner_distances.data(), counts_.inside, counts_.below, k, range_);
    s_.found.count = k;
    s_.found.last = {counted.limit, SpatialIndex::kPaddingId};
    if (counted.count != k) s_.found.last = SplitTies(index, counted, k, s_.found, s_.tied_ids);
    Keep(next_count, next_radius);
  }

 private:
  HWY_INLINE void Keep(size_t next_count, float next_radius) {
    const float growth = GuessGrowth(next_count);
    range_ = {next_radius / growth, next_radius * growth};
    counts_ = KeepLeaves(s_.found.last.squared_distance, range_, s_);
  }

  SearchScratch& s_;
  DistanceRange range_{};
  DistanceCounts counts_{};
};

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_SCALES_NARROW_INL_H_
