// Takes back the results of points whose neighborhoods reach across a seam.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/estimators/curvature_field.h"
#include "core/estimators/options.h"
#include "core/estimators/seams/seam_marks.h"
#include "core/index/spatial_index.h"

namespace curvd {

// How many points lost each status, by PointStatus.
using RefusedCounts = std::array<uint64_t, kPointStatusEnd>;

// Gives PointStatus::kOpposedNormals to those points of a group that are marked, or are OK and have within the radius
// of their result both a marked point and normals on the other side: one that is more than a right angle from the
// point's own, or from that of a marked point. Of others, only points whose normals cancel out
// (kInconsistentNormals) change, if they are marked. Where many more points are as near as the last neighbor than
// the neighborhood holds, the point may be refused as well: that bounds the time. Adds what the points were to
// `refused`. `results` are those of the whole cloud, by slot, and hold the group's; the radius of a radius neighborhood
// stays. Thread-safe for distinct groups and distinct `refused`.
void RefuseAtSeams(const EstimatorOptions& options, const SpatialIndex& index, const SeamMarks& marks, size_t group,
                   PointCurvature* results, RefusedCounts& refused);

}  // namespace curvd
