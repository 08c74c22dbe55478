// What an automatic estimate has chosen, and why.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace curvd {

// One way to estimate that the choice has looked at.
struct ScaleOutcome {
  std::string_view estimator;  // as in EstimatorOptions
  uint32_t neighbor_count;
  // Of the mean curvature over the sampled points, in 1 / the caller's length unit: what it is expected to be off by;
  // how much of that is noise, as the difference of two halves of a neighborhood shows it; and how much is detail lost,
  // as both halves show it.
  double error;
  double noise;
  double bias;
  // Its mean weight in the results, over the sampled points: 0 for those that were not chosen. The sum over all is 1.
  double share;
};

struct ScaleReport {
  // By estimator, then by neighbor count; empty: the cloud is too small to judge. Of the two degrees of jets that there
  // are at one count, that which is expected to be off less, with the share of both.
  std::vector<ScaleOutcome> outcomes;
  uint32_t sampled_points = 0;
  // Standard deviation of the noise of positions, in the caller's length unit, as the residuals of fits show it; detail
  // that is smaller than a neighborhood counts as noise.
  double sigma = 0.0;
  // The same of the noise of normals along each tangent, in radians, beyond what noise of positions makes of it; none
  // where no sampled point has enough neighbors.
  std::optional<double> normal_sigma = std::nullopt;

  void Add(const ScaleOutcome& outcome) {
    for (ScaleOutcome& other : outcomes) {
      if (other.estimator != outcome.estimator || other.neighbor_count != outcome.neighbor_count) continue;
      const double share = other.share + outcome.share;
      if (outcome.error < other.error) other = outcome;
      other.share = share;
      return;
    }
    outcomes.push_back(outcome);
  }
};

}  // namespace curvd
