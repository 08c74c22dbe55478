// Where each point of a cloud was seen from.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "absl/status/status.h"
#include "core/base/page_array.h"
#include "core/cloud/cloud.h"
#include "proto/bulk_message.h"

namespace curvd {

// Keeps the viewpoints as doubles, in one array. Not thread-safe; const methods are.
class Viewpoints {
 public:
  // Bytes a point that this holds; at the peak, where nobody knows how many points will come, kGrowing times as many.
  static constexpr size_t kBytesPerPoint = 3 * sizeof(double);
  static constexpr size_t kGrowing = 3;

  // Says how many will come, so that one array of their size is made for them. REQUIRES: called before Append.
  void Expect(size_t points) { expected_ = points; }

  // Appends viewpoints of `type`, any values. Errors: ErrorKind::kOutOfMemory. REQUIRES: `pieces` hold whole points.
  absl::Status Append(const curvature::wire::Pieces& pieces, ScalarType type);

  // How many viewpoints in a row, from `first` on, are finite: `most` at most. REQUIRES: first + most <= size().
  size_t FiniteRun(size_t first, size_t most) const;

  size_t size() const { return size_; }
  const std::array<double, 3>& operator[](size_t i) const { return points_[i]; }
  std::span<const std::array<double, 3>> span() const { return points_.span().first(size_); }

 private:
  absl::Status Reserve(size_t size);

  size_t expected_ = 0;
  size_t size_ = 0;
  PageArray<std::array<double, 3>> points_;
};

}  // namespace curvd
