// The results of an estimate at each of its scales.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/base/page_array.h"
#include "core/cloud/point_set.h"
#include "core/estimators/curvature_field.h"
#include "core/estimators/options.h"
#include "core/estimators/seams/seam_marks.h"
#include "core/index/spatial_index.h"

namespace curvd {

// An array of points for each scale, the largest scale first (EstimatorOptions::AtScale), and the marks of the seams
// that are found at it. Not thread-safe, but for what is done to distinct points.
class ScaleFields {
 public:
  // May throw std::bad_alloc.
  explicit ScaleFields(const EstimatorOptions& options);

  size_t count() const { return options_.size(); }
  const EstimatorOptions& options(size_t scale) const { return options_[scale]; }
  PageArray<PointCurvature>& points(size_t scale) { return points_[scale]; }
  // Where the results of scales from `scale` on go.
  std::vector<PointCurvature*> Places(size_t scale);

  // Makes arrays of so many points, whose results are undefined. Errors: ErrorKind::kOutOfMemory.
  absl::Status Allocate(size_t point_count);
  // Sets points [first, last) of all scales to a result without curvature.
  void Fill(size_t first, size_t last, PointStatus status);
  // Takes the results of one point at scales from `scale` on back, but for their radii, and moves it among the counts
  // of all statuses.
  void Refuse(size_t scale, size_t slot, PointStatus status, std::array<uint64_t, kPointStatusEnd>& status_counts);
  // The first scale with no more neighbors than the index holds; count() if there is none.
  size_t FirstServed(size_t point_count) const;
  // Sets the points of the index that get a result to kTooFewNeighbors at one scale.
  void RefuseAll(size_t scale, const SpatialIndex& index);

  // Makes marks for scales from `scale` on. Errors: ErrorKind::kOutOfMemory.
  absl::Status MakeMarks(size_t scale, const SpatialIndex& index);
  SeamMarks& marks(size_t scale) { return marks_[scale]; }
  // The marks of the first scale at which a seam shows; null: at none.
  const SeamMarks* ShownSeam() const;

  size_t bytes() const;
  // Frees the marks, and the arrays.
  void FreeMarks() { marks_.clear(); }
  void Free() { points_.clear(); }

  // A result without curvature at one scale: it has the radius of a radius neighborhood.
  PointCurvature Undefined(size_t scale, PointStatus status) const;

 private:
  std::vector<EstimatorOptions> options_;
  std::vector<PageArray<PointCurvature>> points_;
  std::vector<SeamMarks> marks_;  // by scale; those before the first served one are empty
};

}  // namespace curvd
