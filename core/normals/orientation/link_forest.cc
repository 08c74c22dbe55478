#include "core/normals/orientation/link_forest.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <utility>

namespace curvd {
namespace {

constexpr int kDigitBits = 11, kDigits = 3;
constexpr size_t kDigitValues = size_t{1} << kDigitBits;

size_t DigitOf(uint64_t key, int digit) { return key >> (32 + digit * kDigitBits) & (kDigitValues - 1); }

// Sorts keys by their upper halves, digit by digit; keys that are equal there keep their order. `other` is room for as
// many. Returns where the sorted keys are: one of both.
uint64_t* SortByUpperHalf(uint64_t* keys, uint64_t* other, size_t count) {
  std::array<std::array<uint32_t, kDigitValues>, kDigits> starts{};
  for (size_t i = 0; i < count; ++i) {
    for (int digit = 0; digit < kDigits; ++digit) ++starts[digit][DigitOf(keys[i], digit)];
  }
  for (int digit = 0; digit < kDigits; ++digit) {
    std::array<uint32_t, kDigitValues>& start = starts[digit];
    if (count == 0 || start[DigitOf(keys[0], digit)] == count) continue;  // all are alike
    std::exclusive_scan(start.begin(), start.end(), start.begin(), 0u);
    for (size_t i = 0; i < count; ++i) other[start[DigitOf(keys[i], digit)]++] = keys[i];
    std::swap(keys, other);
  }
  return keys;
}

}  // namespace

void PlaceNumbers::Reset(uint32_t first, uint32_t last, size_t most_others) {
  first_ = first;
  size_inside_ = last - first;
  other_count_ = 0;
  const size_t slots = std::bit_ceil(std::max(2 * most_others, kFewestSlots));
  shift_ = 32 - std::countr_zero(slots);
  slots_.Reserve(slots);
  std::fill_n(slots_.data(), slots, Slot{kFree, 0});
}

uint32_t PlaceNumbers::OfOther(uint32_t place) {
  const size_t last_slot = (size_t{1} << (32 - shift_)) - 1;
  size_t slot = (place * 0x9E3779B1u) >> shift_;  // Fibonacci hashing: places near each other are spread
  while (slots_[slot].place != place && slots_[slot].place != kFree) slot = slot == last_slot ? 0 : slot + 1;
  if (slots_[slot].place == kFree) slots_[slot] = {place, size_inside_ + other_count_++};
  return slots_[slot].number;
}

void DisjointSets::Reset(size_t size) {
  parents_.Reserve(size);
  for (size_t i = 0; i < size; ++i) parents_[i] = static_cast<uint32_t>(i);
}

uint32_t DisjointSets::Find(uint32_t element) {
  while (parents_[element] != element) {
    parents_[element] = parents_[parents_[element]];
    element = parents_[element];
  }
  return element;
}

bool DisjointSets::Join(uint32_t a, uint32_t b) {
  a = Find(a);
  b = Find(b);
  if (a == b) return false;
  parents_[std::max(a, b)] = std::min(a, b);
  return true;
}

size_t KeepForest(NormalLink* links, size_t count, uint32_t first, uint32_t last, ForestScratch& scratch) {
  PlaceNumbers& numbers = scratch.numbers;
  scratch.keys.Reserve(count);
  scratch.sorted_keys.Reserve(count);
  size_t others = 0;
  for (size_t i = 0; i < count; ++i) {
    // Costs are not negative, so that their bits are in their order.
    scratch.keys[i] = uint64_t{std::bit_cast<uint32_t>(links[i].cost)} << 32 | i;
    others += links[i].b - first < last - first ? 0 : 1;
  }
  numbers.Reset(first, last, others);
  scratch.sets.Reset(last - first + others);
  scratch.kept.Reserve(std::min(count, last - first + others));
  const uint64_t* const sorted = SortByUpperHalf(scratch.keys.data(), scratch.sorted_keys.data(), count);
  size_t kept = 0;
  for (size_t i = 0; i < count; ++i) {
    const NormalLink& link = links[static_cast<uint32_t>(sorted[i])];
    if (scratch.sets.Join(link.a - first, numbers.Of(link.b))) scratch.kept[kept++] = link;
  }
  std::copy_n(scratch.kept.data(), kept, links);
  return kept;
}

}  // namespace curvd
