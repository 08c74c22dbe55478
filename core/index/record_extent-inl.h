// The extent of point records, a record a vector.

#if defined(CURVD_CORE_INDEX_RECORD_EXTENT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_INDEX_RECORD_EXTENT_INL_H_
#undef CURVD_CORE_INDEX_RECORD_EXTENT_INL_H_
#else
#define CURVD_CORE_INDEX_RECORD_EXTENT_INL_H_
#endif

#include <algorithm>
#include <cstddef>

#include "core/index/record_extent.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE void ExtendByOne(const PointRecord& record, TreeNode& node) {
  for (int axis = 0; axis < 3; ++axis) {
    node.box.lo[axis] = std::min(node.box.lo[axis], record.position[axis]);
    node.box.hi[axis] = std::max(node.box.hi[axis], record.position[axis]);
  }
  node.min_id = std::min(node.min_id, record.id);
}

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE const PointRecord* ExtendByFours(const PointRecord* first, const PointRecord* /*last*/, TreeNode& /*node*/) {
  return first;
}

#else

// Takes records by fours, each into an extent of its own, so that none waits for the one before it. Returns the first
// record that is left.
HWY_INLINE const PointRecord* ExtendByFours(const PointRecord* first, const PointRecord* last, TreeNode& node) {
  static_assert(sizeof(PointRecord) == 16 && offsetof(PointRecord, id) == 12, "the id is the last lane");
  const hn::FixedTag<float, 4> d;
  const hn::RebindToSigned<decltype(d)> di;
  if (last - first < 4) return first;
  const auto load = [&](ptrdiff_t i) HWY_ATTR { return hn::LoadU(d, reinterpret_cast<const float*>(first + i)); };
  auto lo0 = load(0), lo1 = load(1), lo2 = load(2), lo3 = load(3);
  auto hi0 = lo0, hi1 = lo1, hi2 = lo2, hi3 = lo3;
  auto id0 = hn::BitCast(di, lo0), id1 = hn::BitCast(di, lo1), id2 = hn::BitCast(di, lo2), id3 = hn::BitCast(di, lo3);
  for (first += 4; last - first >= 4; first += 4) {
    const auto v0 = load(0), v1 = load(1), v2 = load(2), v3 = load(3);
    lo0 = hn::Min(lo0, v0), lo1 = hn::Min(lo1, v1), lo2 = hn::Min(lo2, v2), lo3 = hn::Min(lo3, v3);
    hi0 = hn::Max(hi0, v0), hi1 = hn::Max(hi1, v1), hi2 = hn::Max(hi2, v2), hi3 = hn::Max(hi3, v3);
    id0 = hn::Min(id0, hn::BitCast(di, v0)), id1 = hn::Min(id1, hn::BitCast(di, v1));
    id2 = hn::Min(id2, hn::BitCast(di, v2)), id3 = hn::Min(id3, hn::BitCast(di, v3));
  }
  // The lane of the id means nothing in a corner of the box, nor those of the position in the lowest id.
  alignas(16) float lo[4], hi[4];
  alignas(16) int32_t id[4];
  hn::Store(hn::Min(hn::Min(lo0, lo1), hn::Min(lo2, lo3)), d, lo);
  hn::Store(hn::Max(hn::Max(hi0, hi1), hn::Max(hi2, hi3)), d, hi);
  hn::Store(hn::Min(hn::Min(id0, id1), hn::Min(id2, id3)), di, id);
  ExtendByOne({{lo[0], lo[1], lo[2]}, id[3]}, node);
  ExtendByOne({{hi[0], hi[1], hi[2]}, id[3]}, node);
  return first;
}

#endif

inline void ExtendNodeKernel(const PointRecord* first, const PointRecord* last, TreeNode& node) {
  for (first = ExtendByFours(first, last, node); first != last; ++first) ExtendByOne(*first, node);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_INDEX_RECORD_EXTENT_INL_H_
