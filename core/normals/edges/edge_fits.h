// Fits of points beside edges, where the neighborhoods that suit the faces reach across.
#pragma once

#include <cstddef>

#include "absl/status/status.h"
#include "core/index/spatial_index.h"
#include "core/normals/fits/fit_group.h"
#include "core/normals/fits/normal_plan.h"
#include "core/normals/fits/normal_scratch.h"
#include "core/normals/normal_fit.h"

namespace curvd {

// How points of that fit's edge part are told, and fitted. REQUIRES: fit.edge_part is set, as it requires.
EdgePlan PlanEdges(const NormalFit& fit, const SpatialIndex& index);

// FitGroup for a plan with edges. Each point is fitted by the first rung that leaves no more of its heights than noise
// does, and else by the last one. Which rung that is depends on the point alone, whatever else is in the run, and is
// told by all neighbors also where halves are fitted. Thread-safe for distinct scratch. Errors: as FitGroup has them.
absl::Status FitBesideEdges(const SpatialIndex& index, const NormalPlan& plan, size_t group, GroupSample sample,
                            NormalScratch& scratch);

}  // namespace curvd
