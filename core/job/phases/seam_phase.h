// The last phase of an estimate: no point whose neighborhood reaches across a seam keeps a result.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string_view>

#include "absl/status/status.h"
#include "core/base/phase.h"
#include "core/estimators/curvature_field.h"
#include "core/estimators/options.h"
#include "core/estimators/seams/seam_marks.h"
#include "core/index/spatial_index.h"
#include "core/job/phases/group_phase.h"

namespace curvd {

inline constexpr std::string_view kSeamPhase = "seams";

// What the phase works on; all of it outlives the phase.
struct SeamWork {
  const EstimatorOptions& options;
  const SpatialIndex& index;
  const SeamMarks& marks;   // set by the phases before
  PointCurvature* results;  // of the whole cloud, by slot
  // How many points lost each status, by PointStatus, to kOpposedNormals.
  std::array<std::atomic<uint64_t>, kPointStatusEnd>& refused;
};

// Has nothing to do, and takes no time, where the marks show no seam (SeamMarks::ShowSeam). Where
// options.opposed_normals refuses such clouds, a seam is an error, RefusalOf. Does not depend on the order of blocks.
std::unique_ptr<Phase> MakeSeamPhase(const SeamWork& work);

// An error of kind kOpposedNormals, which says how many points are beside a seam, and names the first of them.
absl::Status RefusalOf(const SeamMarks& marks, const SpatialIndex& index);

}  // namespace curvd
