// Which points of a cloud may lie beside a seam: where its surface goes on, but normals change to its other side.
#pragma once

#include <cstddef>
#include <cstdint>

#include "absl/status/statusor.h"
#include "core/base/page_array.h"
#include "core/index/spatial_index.h"

namespace curvd {

// Two bits for each place in the tree order of an index: whether the point may be beside a seam, and whether it is
// without doubt. Marks count where they show a seam.
// Thread-compatible: const methods may run concurrently, and so may Mark for points of distinct groups.
class SeamMarks {
 public:
  SeamMarks() = default;
  // Returns marks for an index of so many groups, none of them set.
  // Errors: ErrorKind::kOutOfMemory, the system gave no memory.
  static absl::StatusOr<SeamMarks> Create(size_t group_count);

  // `place` is a place in the tree order of the index.
  void Mark(size_t place, bool is_sure) {
    GroupMarks& group = groups_[place / kWord];
    const uint64_t bit = uint64_t{1} << (place % kWord);
    group.marked |= bit;
    if (is_sure) group.sure |= bit;
  }
  bool IsMarked(size_t place) const { return (groups_[place / kWord].marked >> (place % kWord) & 1) != 0; }
  bool IsSure(size_t place) const { return (groups_[place / kWord].sure >> (place % kWord) & 1) != 0; }
  bool AnyInGroup(size_t group) const { return groups_[group].marked != 0; }
  // The marks of the points of a leaf, that of its first point in the lowest bit.
  uint32_t InLeaf(size_t leaf) const {
    constexpr size_t kLeaf = SpatialIndex::kLeafSize;
    const size_t place = leaf * kLeaf;
    return static_cast<uint32_t>(groups_[place / kWord].marked >> (place % kWord)) & ((uint32_t{1} << kLeaf) - 1);
  }

  // How many points are beside a seam without doubt.
  uint64_t SurePoints() const;
  // Whether there is a seam: in some 1,024 places one after the other, all marked points are beside one without doubt,
  // or more of them than chance leaves. At the seams of one sheet nearly all have no doubt, and some of ten next to the
  // other sheet of a thin part; where two sheets touch, and at knives with noise in their normals, one of fifty does
  // by chance (docs/numerics/seams.md).
  bool ShowSeam() const;

  size_t bytes() const { return groups_.bytes(); }

 private:
  static constexpr size_t kWord = SpatialIndex::kGroupPoints;
  static_assert(kWord == 64 && kWord % SpatialIndex::kLeafSize == 0);

  struct GroupMarks {
    uint64_t marked;
    uint64_t sure;
  };

  PageArray<GroupMarks> groups_;
};

}  // namespace curvd
