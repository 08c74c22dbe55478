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
  // By estimator, then by neighbor count; empty: the cloud is too small to judge. Of the degrees of a polynomial that
  // there are at one count, that which is expected to be off less, with the share of all. Where two parts of the cloud
  // were judged each for itself, that of the part in which it counts more, with the share in both.
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

  // Adds what was found in a part of the cloud that has this share of the sampled points.
  void AddPart(const ScaleReport& part, double samples_share) {
    for (ScaleOutcome outcome : part.outcomes) {
      outcome.share *= samples_share;
      const auto same = std::find_if(outcomes.begin(), outcomes.end(), [&](const ScaleOutcome& other) {
        return other.estimator == outcome.estimator && other.neighbor_count == outcome.neighbor_count;
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
      return other.estimator == outcome.estimator && other.neighbor_count < outcome.neighbor_count;
    };
    const auto last = std::find_if(outcomes.rbegin(), outcomes.rend(), is_before);
    if (last != outcomes.rend()) return last.base();
    const auto is_like = [&](const ScaleOutcome& other) { return other.estimator == outcome.estimator; };
    return std::find_if(outcomes.begin(), outcomes.end(), is_like);
  }
};

}  // namespace curvd
