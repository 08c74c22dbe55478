// Lists the neighbors of a point in the order in which random strategies number them: that of their ranks, which is the
// same for a cloud and its parts.

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

#include "core/estimators/rows/point_rows-inl.h"
#include "core/estimators/triangles/triangle_scratch.h"
#include "core/search/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Sets order[i] to what belongs to the i-th lowest of `count` distinct numbers, after which kRankPad larger ones
// follow. How many are lower is counted for four vectors at a time, a number after the other.
HWY_INLINE void OrderByCounting(const int32_t* numbers, const uint32_t* belongs, size_t count, uint32_t* order) {
  const IntTag d;
  const size_t lanes = hn::Lanes(d);
  alignas(64) int32_t lower[4 * SpatialIndex::kLeafSize];
  for (size_t i = 0; i < count; i += 4 * lanes) {
    const auto own0 = hn::Load(d, numbers + i), own1 = hn::Load(d, numbers + i + lanes);
    const auto own2 = hn::Load(d, numbers + i + 2 * lanes), own3 = hn::Load(d, numbers + i + 3 * lanes);
    auto lower0 = hn::Zero(d), lower1 = lower0, lower2 = lower0, lower3 = lower0;
    for (size_t j = 0; j < count; ++j) {
      const auto other = hn::Set(d, numbers[j]);
      // A mask is -1 where it is true.
      lower0 = hn::Sub(lower0, hn::VecFromMask(d, hn::Lt(other, own0)));
      lower1 = hn::Sub(lower1, hn::VecFromMask(d, hn::Lt(other, own1)));
      lower2 = hn::Sub(lower2, hn::VecFromMask(d, hn::Lt(other, own2)));
      lower3 = hn::Sub(lower3, hn::VecFromMask(d, hn::Lt(other, own3)));
    }
    hn::Store(lower0, d, lower);
    hn::Store(lower1, d, lower + lanes);
    hn::Store(lower2, d, lower + 2 * lanes);
    hn::Store(lower3, d, lower + 3 * lanes);
    const size_t here = std::min(4 * lanes, count - i);
    for (size_t k = 0; k < here; ++k) order[lower[k]] = belongs[i + k];
  }
}

// The same by the numbers' digits, the lowest first. REQUIRES: they are not negative. `spare` has room for 2 count.
inline void OrderByDigits(const int32_t* numbers, const uint32_t* belongs, size_t count, uint64_t* spare,
                          uint32_t* order) {
  constexpr size_t kDigits = 256;
  uint64_t *from = spare, *to = spare + count;
  uint64_t used = 0;
  for (size_t i = 0; i < count; ++i) {
    from[i] = uint64_t{static_cast<uint32_t>(numbers[i])} << 32 | belongs[i];
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

// Lists the neighbors of a point, which were just found in `leaves`, in the order of their ranks: s.order gets where
// their rows begin. Returns their number.
HWY_NOINLINE inline size_t ListRanked(const SpatialIndex& index, const LeafList& leaves, TriangleScratch& s) {
  constexpr size_t kFew = 128;  // digits are faster above
  const Neighborhood& found = s.search.found;
  s.rows.Start(leaves);
  s.ranks.Reserve(found.count + TriangleScratch::kRankPad);
  s.listed.Reserve(found.count + TriangleScratch::kRankPad);
  s.order.Reserve(found.count + TriangleScratch::kOrderPad);
  int32_t* const ranks = s.ranks.data();
  uint32_t* const listed = s.listed.data();
  size_t count = 0;
  const auto list = [&](const NearPoints& near, FloatMask inside_floats) CURVD_INLINED {
    const IntTag d;
    const auto inside = hn::RebindMask(d, inside_floats);
    const size_t kept = hn::CountTrue(d, inside);
    if (kept == 0) return;
    const uint32_t first = FirstRow(index, near.leaf, found.positions[near.near], s.rows);
    const auto row = IntsFrom(static_cast<int32_t>(first + near.place));
    hn::StoreU(hn::Compress(hn::Load(d, index.positions(near.leaf).id + near.place), inside), d, ranks + count);
    hn::StoreU(hn::Compress(hn::ShiftLeft<PointRows::kRowBits>(row), inside), d,
               reinterpret_cast<int32_t*>(listed) + count);
    count += kept;
  };
  ForEachInside(index, found, list);
  if (count > kFew) {
    s.digits.Reserve(2 * count);
    OrderByDigits(ranks, listed, count, s.digits.data(), s.order.data());
  } else {
    std::fill_n(ranks + count, TriangleScratch::kRankPad, std::numeric_limits<int32_t>::max());
    OrderByCounting(ranks, listed, count, s.order.data());
  }
  s.search.work += count;
  return count;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_
