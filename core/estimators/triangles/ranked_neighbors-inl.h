// Lists the neighbors of a point in the order in which random strategies number them: that of their ranks, which is the
// same for a cloud and its parts.

#if defined(CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_
#undef CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_
#endif

#include <cstddef>
#include <cstdint>

#include "core/estimators/rows/point_rows-inl.h"
#include "core/estimators/triangles/rank_numbers.h"
#include "core/estimators/triangles/triangle_scratch.h"
#include "core/search/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

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
  const Neighborhood& found = s.search.found;
  s.rows.Start(leaves);
  s.search.work += s.numbers.Start(index, leaves);
  s.found_numbers.Reserve(found.count + SpatialIndex::kLeafSize);
  s.listed.Reserve(found.count + SpatialIndex::kLeafSize);
  s.order.Reserve(found.count + TriangleScratch::kOrderPad);
  auto* const found_numbers = reinterpret_cast<int32_t*>(s.found_numbers.data());
  auto* const listed = reinterpret_cast<int32_t*>(s.listed.data());
  size_t count = 0;
  const auto list = [&](const NearPoints& near, FloatMask inside_floats) CURVD_INLINED {
    const IntTag d;
    const auto inside = hn::RebindMask(d, inside_floats);
    const size_t kept = hn::CountTrue(d, inside);
    if (kept == 0) return;
    const uint32_t position = found.positions[near.near];
    const uint32_t first = FirstRow(index, near.leaf, position, s.rows);
    const auto row = IntsFrom(static_cast<int32_t>(first + near.place));
    const auto* numbers = reinterpret_cast<const int32_t*>(s.numbers.of(position)) + near.place;
    hn::StoreU(hn::Compress(hn::Load(d, numbers), inside), d, found_numbers + count);
    hn::StoreU(hn::Compress(hn::ShiftLeft<PointRows::kRowBits>(row), inside), d, listed + count);
    count += kept;
  };
  ForEachInside(index, found, list);
  uint32_t* const slots = s.numbers.slots();
  for (size_t i = 0; i < count; ++i) slots[s.found_numbers[i]] = s.listed[i];
  s.search.work += count + leaves.size();
  return EmptySlots(s.numbers, s.order.data());
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_TRIANGLES_RANKED_NEIGHBORS_INL_H_
