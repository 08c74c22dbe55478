// Which points of a cloud may lie beside a seam: where its surface goes on, but normals change to its other side. Marks
// count where at least one point does without doubt.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "absl/status/statusor.h"
#include "core/base/page_array.h"
#include "core/index/spatial_index.h"

namespace curvd {

// A bit for each place in the tree order of an index. The marks of one group are one word.
// Thread-compatible: const methods may run concurrently, and so may Mark for points of distinct groups.
class SeamMarks {
 public:
  SeamMarks() = default;
  // Returns marks for an index of so many groups, none of them set.
  // Errors: ErrorKind::kOutOfMemory, the system gave no memory.
  static absl::StatusOr<SeamMarks> Create(size_t group_count) {
    auto words = PageArray<uint64_t>::Create(group_count);
    if (!words.ok()) return words.status();
    SeamMarks marks;
    marks.words_ = *std::move(words);
    std::fill(marks.words_.data(), marks.words_.data() + group_count, 0);
    return marks;
  }

  // `place` is a place in the tree order of the index.
  void Mark(size_t place) { words_[place / kWord] |= uint64_t{1} << (place % kWord); }
  bool IsMarked(size_t place) const { return (words_[place / kWord] >> (place % kWord) & 1) != 0; }
  // The marks of the points of a leaf, that of its first point in the lowest bit.
  uint32_t InLeaf(size_t leaf) const {
    constexpr size_t kLeaf = SpatialIndex::kLeafSize;
    const size_t place = leaf * kLeaf;
    return static_cast<uint32_t>(words_[place / kWord] >> (place % kWord)) & ((uint32_t{1} << kLeaf) - 1);
  }
  size_t bytes() const { return words_.bytes(); }

 private:
  static constexpr size_t kWord = SpatialIndex::kGroupPoints;
  static_assert(kWord == 64 && kWord % SpatialIndex::kLeafSize == 0);

  PageArray<uint64_t> words_;
};

}  // namespace curvd
