// Collects the neighbors of a query, and the order in which random strategies number them: that of their ranks, which
// is the same for a cloud and its parts.

#if defined(CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_
#undef CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/estimators/neighbors-inl.h"
#include "core/estimators/triangles/triangle_scratch.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Sets order[i] to the place of the i-th lowest of `count` distinct numbers, after which 2 kPad larger ones follow. How
// many are lower is counted for two vectors at a time, a number after the other.
HWY_INLINE void OrderByCounting(const int32_t* numbers, size_t count, uint32_t* order) {
  const IntTag d;
  const size_t lanes = hn::Lanes(d);
  alignas(64) int32_t lower[2 * SpatialIndex::kLeafSize];
  for (size_t i = 0; i < count; i += 2 * lanes) {
    const auto own0 = hn::Load(d, numbers + i), own1 = hn::Load(d, numbers + i + lanes);
    auto lower0 = hn::Zero(d), lower1 = hn::Zero(d);
    for (size_t j = 0; j < count; ++j) {
      const auto other = hn::Set(d, numbers[j]);
      // A mask is -1 where it is true.
      lower0 = hn::Sub(lower0, hn::VecFromMask(d, hn::Lt(other, own0)));
      lower1 = hn::Sub(lower1, hn::VecFromMask(d, hn::Lt(other, own1)));
    }
    hn::Store(lower0, d, lower);
    hn::Store(lower1, d, lower + lanes);
    const size_t here = std::min(2 * lanes, count - i);
    for (size_t k = 0; k < here; ++k) order[lower[k]] = static_cast<uint32_t>(i + k);
  }
}

// The same by the numbers' digits, the lowest first. REQUIRES: they are not negative. `spare` has room for 2 count.
inline void OrderByDigits(const int32_t* numbers, size_t count, uint64_t* spare, uint32_t* order) {
  constexpr size_t kDigits = 256;
  uint64_t *from = spare, *to = spare + count;
  uint64_t used = 0;
  for (size_t i = 0; i < count; ++i) {
    from[i] = uint64_t{static_cast<uint32_t>(numbers[i])} << 32 | i;
    used |= from[i];
  }
  for (int shift = 32; shift < 64 && used >> shift != 0; shift += 8) {
    uint32_t ends[kDigits] = {};
    for (size_t i = 0; i < count; ++i) ++ends[from[i] >> shift & (kDigits - 1)];
    uint32_t end = 0;
    for (uint32_t& digit : ends) end += std::exchange(digit, end);
    for (size_t i = 0; i < count; ++i) to[ends[from[i] >> shift & (kDigits - 1)]++] = from[i];
    std::swap(from, to);
  }
  for (size_t i = 0; i < count; ++i) order[i] = static_cast<uint32_t>(from[i]);
}

// A visitor of GroupSearch: as NeighborCollector, and sets s.order.
class RankedCollector {
 public:
  RankedCollector(const SpatialIndex& index, const QueryPoint& query, TriangleScratch& s, NormalSums& sums)
      : index_(&index), scratch_(&s), neighbors_(index, query, s.neighbors, sums) {}

  HWY_INLINE void Start(size_t count) {
    neighbors_.Start(count);
    scratch_->ranks.Reserve(count + TriangleScratch::kRankPad);
    scratch_->order.Reserve(count);
    if (count > kFew) scratch_->digits.Reserve(2 * count);
    count_ = 0;
  }
  HWY_INLINE void operator()(const NearPoints& near, FloatMask inside) {
    const IntTag d;
    neighbors_(near, inside);
    const auto ranks = hn::Load(d, index_->positions(near.leaf).id + near.place);
    hn::StoreU(hn::Compress(ranks, hn::RebindMask(d, inside)), d, scratch_->ranks.data() + count_);
    count_ += hn::CountTrue(FloatTag(), inside);
  }
  HWY_INLINE void Finish() {
    neighbors_.Finish();
    int32_t* const ranks = scratch_->ranks.data();
    uint32_t* const order = scratch_->order.data();
    if (count_ > kFew) return OrderByDigits(ranks, count_, scratch_->digits.data(), order);
    std::fill_n(ranks + count_, TriangleScratch::kRankPad, std::numeric_limits<int32_t>::max());
    OrderByCounting(ranks, count_, order);
  }

 private:
  static constexpr size_t kFew = 128;  // digits are faster above

  const SpatialIndex* index_;
  TriangleScratch* scratch_;
  NeighborCollector neighbors_;
  size_t count_ = 0;
};

// ForEachCollected with that collector.
template <typename Visit>
HWY_INLINE absl::Status ForEachRanked(const SpatialIndex& index, const NeighborhoodPlan& plan, TriangleScratch& s,
                                      Visit visit) {
  QueryPoint query;
  NormalSums normals;
  const RankedCollector collector(index, query, s, normals);
  return ForEachNeighborhood(index, plan, query, normals, collector, s, visit);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_
