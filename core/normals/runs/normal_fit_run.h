// A run that makes the normals of a cloud.
#pragma once

#include <cstddef>
#include <memory>

#include "absl/status/status.h"
#include "core/base/page_array.h"
#include "core/estimators/strategy.h"
#include "core/index/spatial_index.h"
#include "core/normals/normal_fit.h"

namespace curvd {

// Quality of the normals of an index, by place in the tree order: leaf * SpatialIndex::kLeafSize + lane.
struct NormalQuality {
  PageArray<PointStatus> status;
  // Empty unless they are wanted.
  PageArray<float> residual;
  PageArray<float> variance_ratio;

  // Errors: ErrorKind::kOutOfMemory.
  absl::Status Create(size_t places, bool wants_all);
  size_t bytes() const { return status.bytes() + residual.bytes() + variance_ratio.bytes(); }
};

// A run of one phase, "normals", which fits every point, halo included, and writes its normal to the index, NaN where
// there is none, and its quality. The counts of its scratch are of the points that get a result. Normals have any sign.
// REQUIRES: index.has_normals(); `quality` has a place for each point of each leaf; both outlive the run.
std::unique_ptr<StrategyRun> StartNormalFit(const NormalFit& fit, SpatialIndex& index, NormalQuality& quality);

}  // namespace curvd
