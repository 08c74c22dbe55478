#include "core/select_nth.h"

#include <algorithm>
#include <cmath>

namespace curvd {
namespace {

constexpr ptrdiff_t kSmall = 48;  // below this, introselect is as good
constexpr size_t kMaxSample = 512;

bool Less(const PointRecord& a, const PointRecord& b, int axis) {
  const float x = a.position[axis], y = b.position[axis];
  return (x < y) | ((x == y) & (a.id < b.id));
}

// Moves records less than `pivot` to the front and returns their end. No branch depends on a comparison: at a median
// pivot each would be mispredicted half of the time.
PointRecord* Partition(PointRecord* first, PointRecord* last, const PointRecord pivot, int axis) {
  PointRecord* boundary = first;
  for (PointRecord* it = first; it != last; ++it) {
    const PointRecord record = *it;
    *it = *boundary;
    *boundary = record;
    boundary += Less(record, pivot, axis);
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

void SelectNth(PointRecord* first, PointRecord* nth, PointRecord* last, int axis) {
  // Every round cuts the range to the records between two sampled ones: about 1.5 passes for the first, and little
  // after it.
  while (last - first > kSmall && nth != last) {
    const ptrdiff_t before = last - first;
    const Bracket bracket = SampleBracket(first, before, nth - first, axis);
    PointRecord* high = Partition(first, last, bracket.high, axis);
    (nth < high ? last : first) = high;
    if (nth < high) {
      PointRecord* low = Partition(first, last, bracket.low, axis);
      (nth < low ? last : first) = low;
    }
    if (last - first > before - before / 8) break;  // an unlucky sample: introselect has a bound
  }
  if (nth != last) {
    std::nth_element(first, nth, last, [axis](const auto& a, const auto& b) { return Less(a, b, axis); });
  }
}

}  // namespace curvd
