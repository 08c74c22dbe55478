#include "core/job/job_memory.h"

#include <algorithm>
#include <optional>

#include "core/estimators/curvature_field.h"
#include "core/estimators/point_choice.h"
#include "core/estimators/strategy.h"
#include "core/index/spatial_index.h"
#include "core/job/phases/group_phase.h"
#include "core/job/phases/normal_phases.h"
#include "core/job/phases/normal_tasks.h"
#include "core/scale/automatic.h"
#include "core/scale/outliers/outlier_run.h"

namespace curvd {
namespace {

// Of a point, at the peak.
constexpr size_t kCloudAndIndexBytes = 48;

}  // namespace

size_t EstimationBytesPerPoint(const EstimatorOptions& options, const NormalOptions& normals) {
  // Outliers are looked for once what the strategy held is gone.
  const size_t of_outliers = LooksForOutliers(options) ? OutlierRun::kBytesPerPoint : 0;
  return kCloudAndIndexBytes + NormalBytesPerPoint(normals, TasksFor(options, normals)) +
         options.scale_count() * sizeof(PointCurvature) + (options.returns_choice ? sizeof(PointChoice) : 0) +
         std::max(of_outliers, StrategyFor(options).bytes_per_point);
}

size_t EstimationScratchBytes(const EstimatorOptions& options, size_t point_count, int thread_count,
                              const NormalOptions& normals) {
  const size_t block_points = GroupsPerBlock(options) * SpatialIndex::kGroupPoints;
  const size_t blocks = (point_count + block_points - 1) / block_points;
  const Strategy& strategy = StrategyFor(options);
  const size_t shared = strategy.shared_bytes != nullptr ? strategy.shared_bytes(options, point_count) : 0;
  // Normals are done, and their scratch is gone, before the strategy begins.
  return std::max(shared + std::min<size_t>(thread_count, blocks) * strategy.scratch_bytes(options, point_count),
                  NormalScratchBytes(normals, TasksFor(options, normals), point_count, thread_count));
}

size_t NormalsJobBytesPerPoint(const NormalOptions& normals) {
  return kCloudAndIndexBytes + NormalBytesPerPoint(normals, TasksFor(std::nullopt, normals));
}

size_t NormalsJobScratchBytes(const NormalOptions& normals, size_t point_count, int thread_count) {
  return NormalScratchBytes(normals, TasksFor(std::nullopt, normals), point_count, thread_count);
}

}  // namespace curvd
