// Normals of unoriented points: fits to the positions of each point's neighbors, a group of points at a time.
#pragma once

#include <cstddef>
#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/index/spatial_index.h"
#include "core/normals/fits/normal_plan.h"
#include "core/normals/fits/normal_scratch.h"

namespace curvd {

// Which points of a group are fitted: all, or the first one of each leaf.
enum class GroupSample : uint8_t { kAll, kOneOfEachLeaf };

// Fits the points of a group, halo included; what comes out is in `scratch`, with the status of each point. Writes
// nothing else, and reads no normals of other groups. Thread-safe for distinct scratch.
// Errors: ErrorKind::kNeighborhoodTooLarge; kCancelled once the scratch is stopped. May throw std::bad_alloc.
// REQUIRES: index.has_normals(); they may have any values.
absl::Status FitGroup(const SpatialIndex& index, const NormalPlan& plan, size_t group, GroupSample sample,
                      NormalScratch& scratch);

// The same by the plan's own neighborhoods alone, of the points that scratch.chosen tells.
absl::Status FitChosen(const SpatialIndex& index, const NormalPlan& plan, size_t group, GroupSample sample,
                       NormalScratch& scratch);

// The plan by which FitGroup fits that group: of `plan` itself, or of one of its parts. Errors: as FitGroup has them.
absl::StatusOr<const NormalPlan*> PlanOfGroup(const SpatialIndex& index, const NormalPlan& plan, size_t group,
                                              NormalScratch& scratch);

}  // namespace curvd
