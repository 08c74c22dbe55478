#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/index/select_nth.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/index/partition-inl.h"
#include "hwy/highway.h"

#if HWY_ONCE

#include <algorithm>
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

// Records that are partitioned between two looks at `cancelled`: 20 milliseconds.
constexpr ptrdiff_t kSliceRecords = ptrdiff_t{4} << 20;

bool IsSet(const std::atomic<bool>* flag) { return flag != nullptr && flag->load(std::memory_order_relaxed); }

// Moves records less than `pivot` to the front and returns their end, slice by slice.
PointRecord* Partition(PointRecord* first, PointRecord* last, const PointRecord& pivot, int axis,
                       const std::atomic<bool>* cancelled) {
  PointRecord* boundary = first;
  for (PointRecord* slice = first; slice != last && !IsSet(cancelled);) {
    PointRecord* end = slice + std::min(kSliceRecords, last - slice);
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

}  // namespace

void SelectNth(PointRecord* first, PointRecord* nth, PointRecord* last, int axis, const std::atomic<bool>* cancelled) {
  // Every round cuts the range to the records between two sampled ones: about 1.5 passes for the first, and little
  // after it.
  while (last - first > static_cast<ptrdiff_t>(kRankedRecords) && nth != last) {
    const ptrdiff_t before = last - first;
    const Bracket bracket = SampleBracket(first, before, nth - first, axis);
    PointRecord* high = Partition(first, last, bracket.high, axis, cancelled);
    if (IsSet(cancelled)) return;
    (nth < high ? last : first) = high;
    if (nth < high) {
      PointRecord* low = Partition(first, last, bracket.low, axis, cancelled);
      if (IsSet(cancelled)) return;
      (nth < low ? last : first) = low;
    }
    if (last - first > before - before / 8) break;  // an unlucky sample: introselect has a bound
  }
  const auto rest = static_cast<size_t>(last - first);
  if (nth == last || rest < 2) return;
  if (rest <= kRankedRecords) return HWY_DYNAMIC_DISPATCH(SortByRankKernel)(first, rest, axis);
  std::nth_element(first, nth, last, [axis](const auto& a, const auto& b) { return Less(a, b, axis); });
}

}  // namespace curvd

#endif  // HWY_ONCE
