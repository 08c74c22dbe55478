#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/index/select_nth.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/index/partition-inl.h"
#include "hwy/highway.h"

#if HWY_ONCE

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/index/select_nth.h"

namespace curvd {

HWY_EXPORT(PartitionKernel);
HWY_EXPORT(SortByRankKernel);

namespace {

constexpr size_t kMaxSample = 512;

bool Less(const PointRecord& a, const PointRecord& b, int axis) {
  const float x = a.position[axis], y = b.position[axis];
  return (x < y) | ((x == y) & (a.id < b.id));
}

// Moves records less than `pivot` to the front and returns their end, slice by slice; nullptr if it was stopped.
PointRecord* Partition(PointRecord* first, PointRecord* last, const PointRecord& pivot, int axis, StopSign stop) {
  PointRecord* boundary = first;
  for (PointRecord* slice = first; slice != last;) {
    const ptrdiff_t size = std::min(static_cast<ptrdiff_t>(kSlicedRecords), last - slice);
    if (stop.IsSetBefore(static_cast<size_t>(size))) return nullptr;
    PointRecord* end = slice + size;
    PointRecord* middle = HWY_DYNAMIC_DISPATCH(PartitionKernel)(slice, end, pivot, axis);
    // What is less in this slice changes places with as much of what is not less before it.
    const ptrdiff_t less = middle - slice, moved = std::min(less, slice - boundary);
    std::swap_ranges(boundary, boundary + moved, middle - moved);
    boundary += less;
    slice = end;
  }
  return boundary;
}

// Two records of a sorted sample between which record `rank` of [first, first + count) lies with high probability.
struct Bracket {
  PointRecord low;
  PointRecord high;
};

Bracket SampleBracket(const PointRecord* first, size_t count, size_t rank, int axis) {
  PointRecord sample[kMaxSample];
  const size_t size = std::min(kMaxSample, std::max<size_t>(8, static_cast<size_t>(std::sqrt(count)) & ~size_t{1}));
  // A Weyl sequence: spread over the range, and not in step with any regular order of the input.
  uint32_t weyl = 0x2545F491u;
  for (size_t i = 0; i < size; ++i) {
    weyl += 0x9E3779B9u;
    sample[i] = first[(uint64_t{weyl} * count) >> 32];
  }
  std::sort(sample, sample + size, [axis](const auto& a, const auto& b) { return Less(a, b, axis); });
  const double position = static_cast<double>(rank) / count * size;
  const double margin = 0.6 * std::sqrt(size);
  const auto clamp = [size](double i) { return static_cast<size_t>(std::clamp(i, 0.0, size - 1.0)); };
  return {sample[clamp(position - margin)], sample[clamp(position + margin)]};
}

// The range in which a selection looks for its record.
class Selection {
 public:
  Selection(PointRecord* first, PointRecord* nth, PointRecord* last, int axis, StopSign stop)
      : first_(first), nth_(nth), last_(last), axis_(axis), stop_(stop) {}

  size_t size() const { return static_cast<size_t>(last_ - first_); }
  PointRecord* first() const { return first_; }
  PointRecord* last() const { return last_; }

  // Cuts the range to the records between two sampled ones; both return false if they were stopped.
  bool CutBySample() {
    const Bracket bracket = SampleBracket(first_, size(), static_cast<size_t>(nth_ - first_), axis_);
    bool is_below = false;
    if (!CutAt(bracket.high, &is_below)) return false;
    return !is_below || CutAt(bracket.low, &is_below);
  }

  // Halves the range of keys in which the records lie: 63 times at most.
  bool CutByKey() {
    const uint64_t middle = low_key_ + (high_key_ - low_key_) / 2;
    bool is_below = false;
    if (!CutAt(RecordOf(middle), &is_below)) return false;
    (is_below ? high_key_ : low_key_) = middle;
    return true;
  }

 private:
  // Cuts the range at `pivot`; *is_below tells whether the part below it is left.
  bool CutAt(const PointRecord& pivot, bool* is_below) {
    PointRecord* boundary = Partition(first_, last_, pivot, axis_, stop_);
    if (boundary == nullptr) return false;
    *is_below = nth_ < boundary;
    (*is_below ? last_ : first_) = boundary;
    return true;
  }

  // The record with that key. Keys order records as Less does: the coordinate's bits, turned so that they ascend with
  // it, above the 31 bits of the id.
  PointRecord RecordOf(uint64_t key) const {
    const auto ascending = static_cast<uint32_t>(key >> 31);
    constexpr uint32_t kSign = uint32_t{1} << 31;
    const float coordinate = std::bit_cast<float>(ascending & kSign ? ascending ^ kSign : ~ascending);
    PointRecord record{{0.0f, 0.0f, 0.0f}, static_cast<int32_t>(key & (kSign - 1))};
    record.position[axis_] = coordinate;
    return record;
  }

  // Those of the infinities, with every id; what lies beyond them is NaN.
  static constexpr uint64_t kLowestKey = uint64_t{0x007FFFFF} << 31, kHighestKey = uint64_t{0xFF800001} << 31;

  PointRecord* first_;
  PointRecord* const nth_;
  PointRecord* last_;
  const int axis_;
  const StopSign stop_;
  uint64_t low_key_ = kLowestKey, high_key_ = kHighestKey;
};

}  // namespace

void SelectNth(PointRecord* first, PointRecord* nth, PointRecord* last, int axis, StopSign stop) {
  if (nth == last) return;
  // Every round cuts the range to the records between two sampled ones: about 1.5 passes for the first, and little
  // after it.
  Selection range(first, nth, last, axis, stop);
  while (range.size() > kRankedRecords) {
    const size_t before = range.size();
    if (!range.CutBySample()) return;
    if (range.size() <= before - before / 8) continue;
    // An unlucky sample, or one that somebody knew beforehand.
    if (range.size() <= kUnslicedRecords) break;
    if (!range.CutByKey()) return;
  }
  if (range.size() < 2) return;
  if (range.size() <= kRankedRecords) return HWY_DYNAMIC_DISPATCH(SortByRankKernel)(range.first(), range.size(), axis);
  std::nth_element(range.first(), nth, range.last(), [axis](const auto& a, const auto& b) { return Less(a, b, axis); });
}

}  // namespace curvd

#endif  // HWY_ONCE
