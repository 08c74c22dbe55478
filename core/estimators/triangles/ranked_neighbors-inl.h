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

#include "core/estimators/rows/point_rows-inl.h"
#include "core/estimators/triangles/rank_numbers.h"
#include "core/estimators/triangles/triangle_scratch.h"
#include "core/search/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Sets order[i] to what belongs to the i-th lowest of `count` distinct numbers, after which kKeyPad larger ones follow.
// How many are lower is counted for four vectors at a time, a number after the other.
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

// Appends what the slots of a list hold to `order`, which has room for a vector more, and makes them empty. Returns how
// many held something.
HWY_INLINE size_t EmptySlots(RankNumbers& numbers, uint32_t* order) {
  const IntTag d;
  const auto empty = hn::Set(d, static_cast<int32_t>(RankNumbers::kEmpty));
  auto* const slots = reinterpret_cast<int32_t*>(numbers.slots());
  auto* const out = reinterpret_cast<int32_t*>(order);
  size_t count = 0;
  for (size_t i = 0; i < numbers.size(); i += hn::Lanes(d)) {
    const auto slot = hn::Load(d, slots + i);
    const auto full = hn::Ne(slot, empty);
    hn::StoreU(hn::Compress(slot, full), d, out + count);
    hn::Store(empty, d, slots + i);
    count += hn::CountTrue(d, full);
  }
  return count;
}

// Lists the neighbors of a point, which were just found in `leaves`, in the order of their ranks: s.order gets where
// their rows begin. Returns their number.
HWY_NOINLINE inline size_t ListRanked(const SpatialIndex& index, const LeafList& leaves, TriangleScratch& s) {
  constexpr size_t kFew = 64;  // above, numbers that all queries of a list share are faster
  const Neighborhood& found = s.search.found;
  const bool is_few = found.count <= kFew;
  s.rows.Start(leaves);
  if (!is_few) s.search.work += s.numbers.Start(index, leaves) + leaves.size();
  s.keys.Reserve(found.count + TriangleScratch::kKeyPad);
  s.listed.Reserve(found.count + TriangleScratch::kKeyPad);
  s.order.Reserve(found.count + TriangleScratch::kOrderPad);
  int32_t* const keys = s.keys.data();
  uint32_t* const listed = s.listed.data();
  size_t count = 0;
  const auto list = [&](const NearPoints& near, FloatMask inside_floats) CURVD_INLINED {
    const IntTag d;
    const auto inside = hn::RebindMask(d, inside_floats);
    const size_t kept = hn::CountTrue(d, inside);
    if (kept == 0) return;
    const uint32_t first = FirstRow(index, near.leaf, near.position, s.rows);
    const auto row = IntsFrom(static_cast<int32_t>(first + near.place));
    const int32_t* key = is_few ? index.positions(near.leaf).id : s.numbers.of(near.position);
    hn::StoreU(hn::Compress(hn::Load(d, key + near.place), inside), d, keys + count);
    hn::StoreU(hn::Compress(hn::ShiftLeft<PointRows::kRowBits>(row), inside), d,
               reinterpret_cast<int32_t*>(listed) + count);
    count += kept;
  };
  ForEachInside(index, found, list);
  s.search.work += count;
  if (is_few) {
    std::fill_n(keys + count, TriangleScratch::kKeyPad, std::numeric_limits<int32_t>::max());
    OrderByCounting(keys, listed, count, s.order.data());
    return count;
  }
  uint32_t* const slots = s.numbers.slots();
  for (size_t i = 0; i < count; ++i) slots[keys[i]] = listed[i];
  return EmptySlots(s.numbers, s.order.data());
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_
