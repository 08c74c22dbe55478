#include "core/cloud/point_set.h"

#include <algorithm>
#include <array>
#include <functional>
#include <utility>

namespace curvd {
namespace {

struct PlacedId {
  uint64_t id;
  int32_t place;
};

constexpr int kDigitBits = 8;
constexpr size_t kDigits = size_t{1} << kDigitBits;

size_t Digit(uint64_t id, int shift) { return id >> shift & (kDigits - 1); }

// Sorts by id, and points of the same id by place: a digit of the ids at a time, from the lowest, but for those that
// all have in common. `ids` and `other` are scratch of that size; returns which of them has the result.
PlacedId* SortById(PlacedId* ids, PlacedId* other, size_t size) {
  uint64_t all = ~uint64_t{0}, any = 0;
  for (size_t i = 0; i < size; ++i) {
    all &= ids[i].id;
    any |= ids[i].id;
  }
  for (int shift = 0; shift < 64; shift += kDigitBits) {
    if (Digit(all ^ any, shift) == 0) continue;
    std::array<size_t, kDigits> next{};
    for (size_t i = 0; i < size; ++i) ++next[Digit(ids[i].id, shift)];
    size_t begin = 0;
    for (size_t& digit : next) begin += std::exchange(digit, begin);
    for (size_t i = 0; i < size; ++i) other[next[Digit(ids[i].id, shift)]++] = ids[i];
    std::swap(ids, other);
  }
  return ids;
}

}  // namespace

std::optional<PointSet::Twins> PointSet::Rank() {
  if (!has_ids_) return std::nullopt;
  const uint64_t *const begin = ids_.data(), *const end = begin + size_;
  if (std::adjacent_find(begin, end, std::greater_equal<>()) == end) return std::nullopt;
  ScratchArray<PlacedId> first, second;
  first.Reserve(size_);
  second.Reserve(size_);
  for (size_t i = 0; i < size_; ++i) first[i] = {ids_[i], static_cast<int32_t>(i)};
  const PlacedId* const sorted = SortById(first.data(), second.data(), size_);
  for (size_t i = 1; i < size_; ++i) {
    const PlacedId &a = sorted[i - 1], &b = sorted[i];
    if (a.id == b.id) return Twins{static_cast<size_t>(a.place), static_cast<size_t>(b.place), a.id};
  }
  places_.Reserve(size_);
  for (size_t i = 0; i < size_; ++i) {
    ids_[i] = sorted[i].id;
    places_[i] = sorted[i].place;
  }
  is_reordered_ = true;
  if (!has_roles_) return std::nullopt;
  ScratchArray<int32_t> slots;
  slots.Reserve(size_);
  for (size_t i = 0; i < size_; ++i) slots[i] = slots_[places_[i]];
  slots_ = std::move(slots);
  return std::nullopt;
}

}  // namespace curvd
