// Points of the leaves of a list, one after the other: what a query needs of a point that it adds up lies in one place.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/base/scratch_array.h"
#include "core/index/spatial_index.h"
#include "core/search/leaf_list.h"

namespace curvd {

// Rows of leaves of one list at a time, made when first asked for and shared by all queries that search the list.
// Not thread-safe.
class PointRows {
 public:
  static constexpr int kRowBits = 3;
  static constexpr size_t kRow = 1 << kRowBits;  // position, 1, normal, 0
  static constexpr size_t kNormal = 4;           // where the normal begins

  // Forgets the rows of another list.
  void Start(const LeafList& leaves) {
    if (source_ == &leaves && generation_ == leaves.generation()) return;
    source_ = &leaves;
    generation_ = leaves.generation();
    count_ = 0;
    first_.Reserve(leaves.size());
    std::fill_n(first_.data(), leaves.size(), kNone);
  }

  // The row of the first point of the leaf at a position of the list; kNone if Add was not called for it.
  uint32_t first(size_t position) const { return first_[position]; }

  // Makes room for the rows of the leaf at a position of the list; returns the first.
  uint32_t Add(size_t position) {
    const uint32_t first = first_[position] = static_cast<uint32_t>(count_);
    count_ += SpatialIndex::kLeafSize;
    rows_.Reserve(count_ * kRow);
    return first;
  }

  // Bytes held, and held at most for the rows of so many leaves.
  size_t bytes() const { return first_.bytes() + rows_.bytes(); }
  static constexpr size_t MostBytes(size_t leaves) {
    return ScratchArray<uint32_t>::MostBytes(leaves) +
           ScratchArray<float>::MostBytes(leaves * SpatialIndex::kLeafSize * kRow);
  }

  float* row(size_t i) { return rows_.data() + i * kRow; }
  const float* row(size_t i) const { return rows_.data() + i * kRow; }

  static constexpr uint32_t kNone = ~uint32_t{0};

 private:
  const LeafList* source_ = nullptr;
  uint64_t generation_ = 0;
  size_t count_ = 0;
  ScratchArray<uint32_t> first_;
  ScratchArray<float> rows_;
};

}  // namespace curvd
