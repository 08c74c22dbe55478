// What an automatic estimate has chosen, and why.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/normals/trust/fitted_normals.h"

namespace curvd {

// One way to estimate that the choice has looked at.
struct ScaleOutcome {
  std::string_view estimator;  // as in EstimatorOptions
  uint32_t degree;             // of the polynomials of "jet" and "normal-regression"; 0: of others
  uint32_t neighbor_count;
  // Of the mean curvature over the sampled points, in 1 / the caller's length unit: what it is expected to be off by;
  // how much of that is noise, as the difference of two halves of a neighborhood shows it; and how much is detail lost,
  // as both halves show it.
  double error;
  double noise;
  double bias;
  // Its mean weight in the results, over the sampled points: 0 for those that were not chosen. The sum over all is 1.
  double share;

  // Whether both are the same estimator.
  bool IsLike(const ScaleOutcome& other) const { return estimator == other.estimator && degree == other.degree; }
};

struct ScaleReport {
  // By estimator and degree, then by neighbor count, each once; empty: the cloud is too small to judge. Where two parts
  // of the cloud were judged each for itself, that of the part in which it counts more, with the share in both.
  std::vector<ScaleOutcome> outcomes;
  uint32_t sampled_points = 0;
  // Standard deviation of the noise of positions, in the caller's length unit, as the residuals of fits show it; detail
  // that is smaller than a neighborhood counts as noise. Of two parts of the cloud, that of the noisier one.
  double sigma = 0.0;
  // The same of the noise of normals along each tangent, in radians, beyond what noise of positions makes of it; none
  // where no sampled point has enough neighbors. Of two parts of the cloud, the larger one.
  std::optional<double> normal_sigma = std::nullopt;
  // What given normals were made by, where they err by noise of the positions that neighbors share: normals of halves
  // of these fits told it (core/normals/trust/), or those of the fit that is named next.
  std::optional<FittedNormals> fitted_normals = std::nullopt;
  // What they were made anew by, where that is better (core/job/phases/refit_phases.h).
  std::optional<FittedNormals> normals_made_anew = std::nullopt;
  // Whether that of positions is known to be nothing beside the smallest neighborhoods, in all parts.
  bool positions_are_exact = true;

  // Adds what was found in a part of the cloud that has this share of the sampled points.
  void AddPart(const ScaleReport& part, double samples_share) {
    for (ScaleOutcome outcome : part.outcomes) {
      outcome.share *= samples_share;
      const auto same = std::find_if(outcomes.begin(), outcomes.end(), [&](const ScaleOutcome& other) {
        return other.IsLike(outcome) && other.neighbor_count == outcome.neighbor_count;
      });
      if (same == outcomes.end()) {
        outcomes.insert(PlaceOf(outcome), outcome);
        continue;
      }
      const double share = same->share + outcome.share;
      if (outcome.share > same->share) *same = outcome;
      same->share = share;
    }
    sampled_points += part.sampled_points;
    sigma = std::max(sigma, part.sigma);
    normal_sigma = std::max(normal_sigma, part.normal_sigma);
    positions_are_exact = positions_are_exact && part.positions_are_exact;
  }

 private:
  // After the last one of the same estimator with fewer neighbors.
  std::vector<ScaleOutcome>::iterator PlaceOf(const ScaleOutcome& outcome) {
    const auto is_before = [&](const ScaleOutcome& other) {
      return other.IsLike(outcome) && other.neighbor_count < outcome.neighbor_count;
    };
    const auto last = std::find_if(outcomes.rbegin(), outcomes.rend(), is_before);
    if (last != outcomes.rend()) return last.base();
    return std::find_if(outcomes.begin(), outcomes.end(),
                        [&](const ScaleOutcome& other) { return other.IsLike(outcome); });
  }
};

}  // namespace curvd
