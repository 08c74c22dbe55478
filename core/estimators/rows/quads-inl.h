// Rows of four numbers of 32 bits, a row for each lane of a vector: loaded to vectors of their first, second, third and
// fourth numbers, and stored from them. From the caches that is far faster than gathers, which load number by number.

#if defined(CURVD_CORE_ESTIMATORS_ROWS_QUADS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_ROWS_QUADS_INL_H_
#undef CURVD_CORE_ESTIMATORS_ROWS_QUADS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_ROWS_QUADS_INL_H_
#endif

#include <cstddef>

#include "core/index/vectors-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// A row a lane. D: FloatTag or IntTag.
template <class D>
struct Quads {
  hn::Vec<D> x, y, z, w;
};

#if HWY_TARGET == HWY_SCALAR

template <class D, typename At>
HWY_INLINE Quads<D> LoadQuads(D d, At at) {
  const auto* from = at(0);
  return {hn::Set(d, from[0]), hn::Set(d, from[1]), hn::Set(d, from[2]), hn::Set(d, from[3])};
}

template <class D, typename At>
HWY_INLINE void StoreQuads(const Quads<D>& quads, D, At at) {
  auto* to = at(0);
  to[0] = hn::GetLane(quads.x);
  to[1] = hn::GetLane(quads.y);
  to[2] = hn::GetLane(quads.z);
  to[3] = hn::GetLane(quads.w);
}

#else

// Four numbers from where `at(lane)` points to, for lane, lane + 4, ...: a block of the vector each.
template <class D, typename At>
HWY_INLINE hn::Vec<D> LoadBlocks(D d, At at, size_t lane) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    return hn::Load(d, at(lane));
  } else {
    const hn::Half<D> half;
    const auto low = LoadBlocks(half, at, lane), high = LoadBlocks(half, at, lane + hn::MaxLanes(half));
    return hn::Combine(d, high, low);
  }
}

// Stores blocks to where LoadBlocks loads them from.
template <class D, typename At>
HWY_INLINE void StoreBlocks(D d, hn::Vec<D> blocks, At at, size_t lane) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    hn::Store(blocks, d, at(lane));
  } else {
    const hn::Half<D> half;
    StoreBlocks(half, hn::LowerHalf(half, blocks), at, lane);
    StoreBlocks(half, hn::UpperHalf(half, blocks), at, lane + hn::MaxLanes(half));
  }
}

// Loads the rows that `at(lane)` points to, each aligned to 16 bytes.
template <class D, typename At>
HWY_INLINE Quads<D> LoadQuads(D d, At at) {
  const hn::RepartitionToWide<D> wide;
  const auto row0 = LoadBlocks(d, at, 0), row1 = LoadBlocks(d, at, 1);
  const auto row2 = LoadBlocks(d, at, 2), row3 = LoadBlocks(d, at, 3);
  const auto xy_01 = hn::BitCast(wide, hn::InterleaveLower(d, row0, row1));
  const auto xy_23 = hn::BitCast(wide, hn::InterleaveLower(d, row2, row3));
  const auto zw_01 = hn::BitCast(wide, hn::InterleaveUpper(d, row0, row1));
  const auto zw_23 = hn::BitCast(wide, hn::InterleaveUpper(d, row2, row3));
  return {
      hn::BitCast(d, hn::InterleaveLower(wide, xy_01, xy_23)), hn::BitCast(d, hn::InterleaveUpper(wide, xy_01, xy_23)),
      hn::BitCast(d, hn::InterleaveLower(wide, zw_01, zw_23)), hn::BitCast(d, hn::InterleaveUpper(wide, zw_01, zw_23))};
}

// Stores the rows to where `at(lane)` points to, each aligned to 16 bytes.
template <class D, typename At>
HWY_INLINE void StoreQuads(const Quads<D>& quads, D d, At at) {
  const hn::RepartitionToWide<D> wide;
  const auto xy_01 = hn::BitCast(wide, hn::InterleaveLower(d, quads.x, quads.y));
  const auto xy_23 = hn::BitCast(wide, hn::InterleaveUpper(d, quads.x, quads.y));
  const auto zw_01 = hn::BitCast(wide, hn::InterleaveLower(d, quads.z, quads.w));
  const auto zw_23 = hn::BitCast(wide, hn::InterleaveUpper(d, quads.z, quads.w));
  StoreBlocks(d, hn::BitCast(d, hn::InterleaveLower(wide, xy_01, zw_01)), at, 0);
  StoreBlocks(d, hn::BitCast(d, hn::InterleaveUpper(wide, xy_01, zw_01)), at, 1);
  StoreBlocks(d, hn::BitCast(d, hn::InterleaveLower(wide, xy_23, zw_23)), at, 2);
  StoreBlocks(d, hn::BitCast(d, hn::InterleaveUpper(wide, xy_23, zw_23)), at, 3);
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_ROWS_QUADS_INL_H_
