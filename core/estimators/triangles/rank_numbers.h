// Numbers the points of the leaves of a list by their ranks, once for all queries that search the list.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/scratch_array.h"
#include "core/index/spatial_index.h"
#include "core/search/leaf_list.h"

namespace curvd {

// Number i is that of the point with the i-th lowest rank of all in the leaves. Whoever puts some of the points into
// slots() by their numbers finds them there in the order of their ranks, and need not sort. Not thread-safe.
class RankNumbers {
 public:
  // What a slot holds in which nothing was put.
  static constexpr uint32_t kEmpty = ~uint32_t{0};

  // Numbers the points of a list, unless they are numbered already: then returns 0, else their number. All slots are
  // then empty. REQUIRES: the list of the last call lives.
  size_t Start(const SpatialIndex& index, const LeafList& leaves);

  // Points numbered.
  size_t size() const { return size_; }
  // The numbers of the points of the leaf at a position of the list, by their place in it: SpatialIndex::kLeafSize, of
  // which those without a point are any. Aligned for any vector.
  const int32_t* of(size_t position) const { return numbers_.data() + position * SpatialIndex::kLeafSize; }

  // A slot for each number, padded with empty ones to a multiple of SpatialIndex::kLeafSize. Whoever puts something
  // into them makes them kEmpty again.
  uint32_t* slots() { return slots_.data(); }

  // Bytes held, and held at most for lists of so many leaves.
  size_t bytes() const { return numbers_.bytes() + slots_.bytes() + sorted_.bytes(); }
  static constexpr size_t MostBytes(size_t leaves) {
    const size_t places = leaves * SpatialIndex::kLeafSize;
    return ScratchArray<int32_t>::MostBytes(places) + ScratchArray<uint32_t>::MostBytes(places) +
           ScratchArray<uint64_t>::MostBytes(2 * places);
  }

 private:
  const LeafList* source_ = nullptr;
  uint64_t generation_ = 0;
  size_t size_ = 0;
  ScratchArray<int32_t> numbers_;
  ScratchArray<uint32_t> slots_;
  ScratchArray<uint64_t> sorted_;  // ranks above places in the list, and as many while they are sorted
};

}  // namespace curvd
