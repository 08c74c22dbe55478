#include "core/normals/fits/normal_plan.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <variant>

#include "core/normals/edges/edge_fits.h"
#include "core/normals/normal_options.h"

namespace curvd {
namespace {

NormalFit QuadricFit(uint32_t neighbor_count) {
  NormalFit fit;
  fit.neighborhood = NeighborCount{neighbor_count};
  return fit;
}

}  // namespace

NormalPlan::NormalPlan(const NormalFit& fit, const SpatialIndex& index)
    : neighborhood(NeighborhoodPlan::Make(fit.ToEstimatorOptions(), index)),
      degree(JetDegree(fit.method)),
      two_sheets(fit.two_sheets),
      shares(fit.shares),
      crosses_lines(fit.crosses_lines),
      half(fit.half) {
  if (fit.edge_part.has_value()) edges = std::make_shared<EdgePlan>(PlanEdges(fit, index));
  if (!fit.noisy_part.has_value()) return;
  NoisyPlan plans{NormalPlan(QuadricFit(fit.noisy_part->probe_count), index),
                  NormalPlan(FitOfNoisyPart(fit), index),
                  {},
                  fit.noisy_part->least_variance,
                  fit.noisy_part->quiet_variance};
  NormalFit quiet = fit;
  quiet.noisy_part.reset();
  const uint32_t least = std::max(fit.noisy_part->probe_count, LeastNeighborCount(fit.method));
  for (uint32_t count = std::get<NeighborCount>(fit.neighborhood).count;; count /= 2) {
    quiet.neighborhood = NeighborCount{count};
    quiet.shares = fit.shares && count >= NormalFit::kLeastShared;
    plans.quiet.push_back(NormalPlan(quiet, index));
    if (count <= least) break;
  }
  noisy = std::make_shared<NoisyPlan>(std::move(plans));
}

}  // namespace curvd
