// What fits of normals need to know of an index, found out once for all groups.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/base/halves.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/index/spatial_index.h"
#include "core/normals/normal_fit.h"

namespace curvd {

struct NoisyPlan;
struct EdgePlan;

// A fit to the neighborhoods of one index. REQUIRES: by count, the index holds as many points.
struct NormalPlan {
  NormalPlan(const NormalFit& fit, const SpatialIndex& index);

  NeighborhoodPlan neighborhood;
  int degree;  // of the polynomial; 0: no polynomial
  bool two_sheets;
  bool shares;
  bool crosses_lines;
  std::optional<Half> half;
  std::shared_ptr<const NoisyPlan> noisy;  // null: groups are fitted alike
  std::shared_ptr<const EdgePlan> edges;   // null: the points of a group are fitted alike
};

struct NoisyPlan {
  NormalPlan probe;  // tells which groups are fitted by the other one
  NormalPlan fit;
  std::vector<NormalPlan> quiet;  // of ever fewer neighbors, each half of those before; the first is that of the fit
  double least_variance, quiet_variance;  // as NoisyPart has both
};

struct EdgePlan {
  std::vector<NormalPlan> rungs;  // of ever fewer neighbors; by the last one, points are fitted whatever it leaves
  std::vector<double> most;       // by rung: the most that a fit to one side leaves of the heights, squared
  bool last_has_halves;           // whether the last rung has enough neighbors for normals of halves
};

}  // namespace curvd
