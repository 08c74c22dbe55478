#include "core/scale/pilot/distance_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

namespace curvd {
namespace {

// Sorts by the upper half, which is that of a float that is not negative: digit by digit, each of which keeps the order
// that the ones before have made.
void SortByFloats(std::vector<uint64_t>& keys, std::vector<uint64_t>& other) {
  // Of fewer keys than this, counting digits takes longer than comparing keys.
  constexpr size_t kFewestToCount = 160;
  if (keys.size() < kFewestToCount) {
    std::sort(keys.begin(), keys.end());
    return;
  }
  constexpr int kDigitBits = 11, kFirstBit = 32, kDigits = 3;
  constexpr uint64_t kDigitMask = (uint64_t{1} << kDigitBits) - 1;
  other.resize(keys.size());
  for (int digit = 0; digit < kDigits; ++digit) {
    const int shift = kFirstBit + digit * kDigitBits;
    const auto digit_of = [shift](uint64_t key) { return static_cast<size_t>(key >> shift & kDigitMask); };
    std::array<uint32_t, kDigitMask + 1> places{};
    for (const uint64_t key : keys) ++places[digit_of(key)];
    std::exclusive_scan(places.begin(), places.end(), places.begin(), 0U);
    for (const uint64_t key : keys) other[places[digit_of(key)]++] = key;
    keys.swap(other);
  }
}

}  // namespace

void OrderByDistance(PilotScratch& s) {
  const NeighborArrays& n = s.neighbors;
  s.squared.resize(n.count);
  s.keys.resize(n.count);
  for (size_t j = 0; j < n.count; ++j) {
    s.squared[j] = n.dx[j] * n.dx[j] + n.dy[j] * n.dy[j] + n.dz[j] * n.dz[j];
    s.keys[j] = uint64_t{std::bit_cast<uint32_t>(s.squared[j])} << 32 | j;
  }
  SortByFloats(s.keys, s.other_keys);
  s.order.resize(n.count);
  std::transform(s.keys.begin(), s.keys.end(), s.order.begin(),
                 [](uint64_t key) { return static_cast<uint32_t>(key); });
  for (auto first = s.order.begin(); first != s.order.end();) {
    const auto is_farther = [&](uint32_t j) { return s.squared[j] != s.squared[*first]; };
    const auto last = std::find_if(first + 1, s.order.end(), is_farther);
    if (last - first > 1) std::sort(first, last, [&](uint32_t a, uint32_t b) { return s.ids[a] < s.ids[b]; });
    first = last;
  }
}

}  // namespace curvd
