#include "core/estimators/triangles/rank_numbers.h"

#include <algorithm>
#include <utility>

namespace curvd {
namespace {

constexpr int kRankShift = 32;

// Sorts numbers by their bits from kRankShift on, digit by digit, the lowest first. `spare` has room for as many;
// returns which of the two holds the result.
uint64_t* SortByRank(uint64_t* from, uint64_t* spare, size_t count) {
  constexpr size_t kDigits = 256;
  uint64_t used = 0;
  for (size_t i = 0; i < count; ++i) used |= from[i];
  for (int shift = kRankShift; shift < 64 && used >> shift != 0; shift += 8) {
    uint32_t ends[kDigits] = {};
    for (size_t i = 0; i < count; ++i) ++ends[from[i] >> shift & (kDigits - 1)];
    uint32_t end = 0;
    for (uint32_t& digit : ends) end += std::exchange(digit, end);
    for (size_t i = 0; i < count; ++i) spare[ends[from[i] >> shift & (kDigits - 1)]++] = from[i];
    std::swap(from, spare);
  }
  return from;
}

}  // namespace

size_t RankNumbers::Start(const SpatialIndex& index, const LeafList& leaves) {
  if (source_ == &leaves && generation_ == leaves.generation()) return 0;
  source_ = &leaves;
  generation_ = leaves.generation();
  constexpr size_t kLeaf = SpatialIndex::kLeafSize;
  const size_t places = leaves.size() * kLeaf;
  numbers_.Reserve(places);
  slots_.Reserve(places);
  sorted_.Reserve(2 * places);
  std::fill_n(slots_.data(), places, kEmpty);
  size_ = 0;
  for (size_t position = 0; position < leaves.size(); ++position) {
    const int32_t* ids = index.positions(leaves.leaf(position)).id;
    const auto points = static_cast<size_t>(index.LeafPoints(leaves.leaf(position)));
    for (size_t i = 0; i < points; ++i) {
      sorted_[size_++] = uint64_t{static_cast<uint32_t>(ids[i])} << kRankShift | (position * kLeaf + i);
    }
    std::fill_n(numbers_.data() + position * kLeaf + points, kLeaf - points, 0);
  }
  const uint64_t* const sorted = SortByRank(sorted_.data(), sorted_.data() + size_, size_);
  for (size_t i = 0; i < size_; ++i) numbers_[static_cast<uint32_t>(sorted[i])] = static_cast<int32_t>(i);
  return size_;
}

}  // namespace curvd
