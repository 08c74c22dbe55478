// A cloud without some of its points.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "absl/status/status.h"
#include "core/base/page_array.h"
#include "core/cloud/cloud.h"
#include "core/index/spatial_index.h"

namespace curvd {

// Makes a cloud of the points of an index, each at its rank, but for those that are left out, and those that the index
// does not hold: these are invalid points, nobody's neighbors. It has the normals of the index, if it takes normals,
// and lies relative to the same origin; its own is 0.
//
// Usage: Allocate; Clear all ranks; Place all leaves; LeaveOut; StartCloud, from where on the index is needed no more;
// Append each block, in order; Take. Clear and Place are thread-safe for distinct ranges.
class RestOfCloud {
 public:
  // REQUIRES: all points of `index` are queries without ids (PointSet), of a cloud of `size` points; it outlives the
  // calls before StartCloud, and has normals if takes_normals.
  RestOfCloud(const SpatialIndex& index, size_t size, bool takes_normals)
      : index_(index), size_(size), takes_normals_(takes_normals) {}

  // Errors: ErrorKind::kOutOfMemory.
  absl::Status Allocate();
  // Ranks [first, last).
  void Clear(size_t first, size_t last);
  // Leaves [first, last) of the index.
  void Place(size_t first, size_t last);
  void LeaveOut(std::span<const int32_t> ranks);
  void StartCloud();
  // Of Cloud::kBlockPoints points each.
  size_t block_count() const { return (size_ + Cloud::kBlockPoints - 1) / Cloud::kBlockPoints; }
  // Errors: ErrorKind::kOutOfMemory. The last block ends the cloud.
  absl::Status Append(size_t block);
  Cloud Take() { return std::move(cloud_); }

  size_t bytes() const { return positions_.bytes() + normals_.bytes() + cloud_.bytes(); }

 private:
  using Vectors = PageArray<std::array<float, 3>>;

  const SpatialIndex& index_;
  const size_t size_;
  const bool takes_normals_;
  Vectors positions_, normals_;  // by rank
  Cloud cloud_;
};

}  // namespace curvd
