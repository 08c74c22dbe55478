// Partition and ranking of point records by vectors.

#if defined(CURVD_CORE_INDEX_PARTITION_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_INDEX_PARTITION_INL_H_
#undef CURVD_CORE_INDEX_PARTITION_INL_H_
#else
#define CURVD_CORE_INDEX_PARTITION_INL_H_
#endif

#include <cstring>

#include "core/index/select_nth.h"
#include "core/index/vectors-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE bool IsLess(const PointRecord& a, const PointRecord& b, int axis) {
  const float x = a.position[axis], y = b.position[axis];
  return (x < y) | ((x == y) & (a.id < b.id));
}

// Moves records less than `pivot` to the front and returns their end. No branch depends on a comparison: at a median
// pivot each would be mispredicted half of the time.
HWY_INLINE PointRecord* PartitionOneByOne(PointRecord* first, PointRecord* last, const PointRecord pivot, int axis) {
  PointRecord* boundary = first;
  for (PointRecord* it = first; it != last; ++it) {
    const PointRecord record = *it;
    *it = *boundary;
    *boundary = record;
    boundary += IsLess(record, pivot, axis);
  }
  return boundary;
}

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE PointRecord* PartitionVectors(PointRecord* first, PointRecord* last, const PointRecord& pivot, int axis) {
  return PartitionOneByOne(first, last, pivot, axis);
}

#else

// A record fills one block of four lanes, its id the last.
class RecordPartition {
 public:
  using Tag = hn::CappedTag<float, 16>;
  using IntTag = hn::RebindToSigned<Tag>;
  using Vec = hn::Vec<Tag>;

  RecordPartition(PointRecord* first, PointRecord* last, const PointRecord& pivot, int axis)
      : left_(first), right_(last), pivot_(pivot), axis_(axis) {}

  // Both ends' first batches wait in registers, so that there is always a batch's room on the side that was read. A
  // batch is several vectors: which side is read next is a branch that nothing predicts.
  HWY_INLINE PointRecord* Run() {
    const Tag d;
    const ptrdiff_t step = static_cast<ptrdiff_t>(hn::Lanes(d) / 4);
    const ptrdiff_t batch = kBatch * step;
    PointRecord *read_left = left_, *read_right = right_;
    if (read_right - read_left < 2 * batch) return PartitionOneByOne(left_, right_, pivot_, axis_);
    Vec first[kBatch], last[kBatch];
    LoadBatch(read_left, step, first);
    read_left += batch;
    read_right -= batch;
    LoadBatch(read_right, step, last);
    while (read_right - read_left >= batch) {
      Vec records[kBatch];
      const bool from_left = read_left - left_ <= right_ - read_right;
      read_right -= from_left ? 0 : batch;
      LoadBatch(from_left ? read_left : read_right, step, records);
      read_left += from_left ? batch : 0;
      StoreBatch(records, step);
    }
    PointRecord rest[kBatch * 4];
    const ptrdiff_t rest_count = read_right - read_left;
    std::memcpy(rest, read_left, static_cast<size_t>(rest_count) * sizeof(PointRecord));
    StoreBatch(first, step);
    StoreBatch(last, step);
    for (ptrdiff_t i = 0; i < rest_count; ++i) StoreOne(rest[i]);
    return left_;
  }

 private:
  static constexpr int kBatch = 4;

  static HWY_INLINE void LoadBatch(const PointRecord* records, ptrdiff_t step, Vec* batch) {
    HWY_UNROLL(kBatch)
    for (int i = 0; i < kBatch; ++i) batch[i] = hn::LoadU(Tag(), (records + i * step)->position);
  }

  HWY_INLINE void StoreBatch(const Vec* batch, ptrdiff_t step) {
    HWY_UNROLL(kBatch)
    for (int i = 0; i < kBatch; ++i) Store(batch[i], step);
  }

  // The lanes of records less than the pivot.
  HWY_INLINE hn::Mask<Tag> Less(Vec records) const {
    const Tag d;
    const IntTag di;
    const Vec key = axis_ == 0   ? hn::Broadcast<0>(records)
                    : axis_ == 1 ? hn::Broadcast<1>(records)
                                 : hn::Broadcast<2>(records);
    const auto id = hn::BitCast(di, hn::Broadcast<3>(records));
    const Vec pivot_key = hn::Set(d, pivot_.position[axis_]);
    const auto earlier = hn::RebindMask(d, hn::Lt(id, hn::Set(di, pivot_.id)));
    return hn::Or(hn::Lt(key, pivot_key), hn::And(hn::Eq(key, pivot_key), earlier));
  }

  // Appends records less than the pivot to the left part, the others to the right part.
  HWY_INLINE void Store(Vec records, ptrdiff_t step) {
    const Tag d;
    const hn::Mask<Tag> less = Less(records);
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
    const auto count = static_cast<ptrdiff_t>(hn::CountTrue(d, less) / 4);
    const ptrdiff_t others = step - count;
    hn::BlendedStore(hn::Compress(records, less), hn::FirstN(d, static_cast<size_t>(4 * count)), d, left_->position);
    left_ += count;
    right_ -= others;
    hn::BlendedStore(hn::Compress(records, hn::Not(less)), hn::FirstN(d, static_cast<size_t>(4 * others)), d,
                     right_->position);
#else
    // One or two records. Stores of some lanes of a vector take longer there, up to ten times.
    static_cast<void>(step);
    StoreBlocks(d, records, BitsFromMask(less));
#endif
  }

  // The same for the records of a vector; of each four bits, the lowest tells whether it is less.
  template <class D>
  HWY_INLINE void StoreBlocks([[maybe_unused]] D d, hn::Vec<D> records, uint64_t less) {
    if constexpr (hn::MaxLanes(D()) == 4) {
      const auto is_less = static_cast<ptrdiff_t>(less & 1);
      right_ -= 1 - is_less;
      hn::StoreU(records, d, (is_less != 0 ? left_ : right_)->position);
      left_ += is_less;
    } else {
      const hn::Half<D> half;
      StoreBlocks(half, hn::LowerHalf(half, records), less);
      StoreBlocks(half, hn::UpperHalf(half, records), less >> hn::MaxLanes(half));
    }
  }

  HWY_INLINE void StoreOne(const PointRecord& record) {
    *(IsLess(record, pivot_, axis_) ? left_++ : --right_) = record;
  }

  PointRecord* left_;   // end of the left part
  PointRecord* right_;  // begin of the right part
  const PointRecord pivot_;
  const int axis_;
};

HWY_INLINE PointRecord* PartitionVectors(PointRecord* first, PointRecord* last, const PointRecord& pivot, int axis) {
  return RecordPartition(first, last, pivot, axis).Run();
}

#endif

PointRecord* PartitionKernel(PointRecord* first, PointRecord* last, const PointRecord& pivot, int axis) {
  return PartitionVectors(first, last, pivot, axis);
}

// Sorts up to kRankedRecords records by counting for each how many precede it.
void SortByRankKernel(PointRecord* first, size_t count, int axis) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  alignas(64) float keys[kRankedRecords];
  alignas(64) int32_t ids[kRankedRecords];
  PointRecord records[kRankedRecords];
  for (size_t i = 0; i < kRankedRecords; ++i) {
    if (i < count) records[i] = first[i];
    keys[i] = i < count ? first[i].position[axis] : 0.0f;
    ids[i] = i < count ? first[i].id : 0;
  }
  for (size_t i = 0; i < count; ++i) {
    const auto key = hn::Set(d, keys[i]);
    const auto id = hn::Set(di, ids[i]);
    size_t rank = 0;
    for (size_t j = 0; j < count; j += hn::Lanes(d)) {
      const auto other = hn::Load(d, keys + j);
      const auto earlier = hn::RebindMask(d, hn::Lt(hn::Load(di, ids + j), id));
      const auto less = hn::Or(hn::Lt(other, key), hn::And(hn::Eq(other, key), earlier));
      rank += hn::CountTrue(d, j + hn::Lanes(d) <= count ? less : hn::And(less, hn::FirstN(d, count - j)));
    }
    first[rank] = records[i];
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_INDEX_PARTITION_INL_H_
