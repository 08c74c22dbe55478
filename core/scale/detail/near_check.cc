#include "core/scale/detail/near_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/base/quantile.h"
#include "core/scale/detail/detail_check.h"

namespace curvd {
namespace {

// 32 and 128 neighbors. What is chosen must look at four times as many.
constexpr std::array<size_t, kMostNearChecks> kCheckRungs = {2, 6};
constexpr size_t kLeastRungsBetween = 4;
constexpr size_t kFewestSamples = 24;
// A small body holds fewer of the samples than are beyond this quantile. Three times that are 3.8 standard deviations
// of noise; what polynomials leave out changes more from place to place.
constexpr double kUsualShare = 0.8, kMostTimesNoise = 3.0, kMostTimesUsual = 5.0;
// Rounding of normals to float32 moves curvature by up to this many times 1 / radius.
constexpr double kRounding32 = 0x1p-20;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

double AverageAt(const PilotPoint& point, const ScaleChoice& choice) {
  double sum = 0.0, weight = 0.0;
  for (size_t c = 0; c < choice.chosen.size(); ++c) {
    const double mean = point.mean[choice.chosen[c].method][choice.chosen[c].rung][PilotPoint::kAll];
    if (!std::isfinite(mean)) continue;
    sum += choice.weights.mean.cloud_weights[c] * mean;
    weight += choice.weights.mean.cloud_weights[c];
  }
  return weight > 0.0 ? sum / weight : kUnknown;
}

struct Check {
  ScaleCandidate candidate;
  double most_difference;
};

std::optional<Check> BestCheckAt(size_t rung, double most_times, PilotPoints samples, const ScaleChoice& choice) {
  std::optional<Check> best;
  for (const size_t method : {kRegressionMethod, kQuarticMethod, kQuadricMethod}) {
    const bool is_candidate = std::any_of(choice.scores.begin(), choice.scores.end(),
                                          [&](const ScaleScore& score) { return score.candidate.method == method; });
    if (!is_candidate) continue;
    std::vector<double> differences, rounding;
    for (const PilotPoint& point : samples) {
      const double difference = std::abs(AverageAt(point, choice) - point.mean[method][rung][PilotPoint::kAll]);
      if (!std::isfinite(difference)) continue;
      differences.push_back(difference);
      rounding.push_back(kRounding32 / point.radius[rung]);
    }
    if (differences.size() < kFewestSamples) continue;
    const double most =
        std::max(most_times * LowerQuantile(differences, kUsualShare), LowerQuantile(rounding, kUsualShare));
    if (!best.has_value() || most < best->most_difference) best = Check{{method, rung}, most};
  }
  return best;
}

}  // namespace

std::vector<NearCheck> FindNearChecks(PilotPoints samples, const ScaleChoice& choice, uint32_t least_count,
                                      bool is_noise_known) {
  std::vector<NearCheck> checks;
  for (const size_t rung : kCheckRungs) {
    if (kScaleRungs[rung] < least_count || FarthestThatCounts(choice) < rung + kLeastRungsBetween) continue;
    const bool is_noise = is_noise_known && DecidesNoise(samples, choice, rung);
    const auto best = BestCheckAt(rung, is_noise ? kMostTimesNoise : kMostTimesUsual, samples, choice);
    if (best.has_value()) checks.push_back({best->candidate, best->most_difference, is_noise});
  }
  return checks;
}

}  // namespace curvd
