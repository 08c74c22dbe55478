#include "core/scale/detail/detail_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/median.h"

namespace curvd {
namespace {

// Of the least expected error; the most that the noise of the check may be.
constexpr double kMostNoiseOfCheck = 6.0;
// Candidates that count less do not tell how far estimates look.
constexpr double kLeastShareOfFarthest = 0.1;
// So many rungs further, neighbors are twice as many. What differs between the halves of a neighborhood is noise if it
// falls by this there: of a regression noise halves. What polynomials leave out of an exact surface grows.
constexpr size_t kRungsToTwice = 2;
constexpr double kLeastFall = 1.4;
// Errors of normals that neighbors share, as those of normals that were made of positions, look like detail. A fit to
// few neighbors follows them, and one to more leaves more; of independent noise it leaves as much.
constexpr size_t kFewRung = 2;
constexpr double kMostRise = 1.1;

double MedianResidual(PilotPoints samples, size_t rung) {
  std::vector<double> residuals;
  for (const PilotPoint& point : samples) {
    if (std::isfinite(point.normal_residual[rung])) residuals.push_back(point.normal_residual[rung]);
  }
  return residuals.empty() ? std::numeric_limits<double>::quiet_NaN() : Median(residuals);
}

bool AreErrorsIndependent(PilotPoints samples, size_t rung) {
  return MedianResidual(samples, rung) <= kMostRise * MedianResidual(samples, kFewRung);
}

}  // namespace

size_t FarthestThatCounts(const ScaleChoice& choice) {
  size_t farthest = 0;
  for (const ScaleScore& score : choice.scores) {
    if (score.share >= kLeastShareOfFarthest) farthest = std::max(farthest, score.candidate.rung);
  }
  return farthest;
}

bool DecidesNoise(PilotPoints samples, const ScaleChoice& choice, size_t rung) {
  const auto score_at = [&](size_t at) {
    return std::find_if(choice.scores.begin(), choice.scores.end(), [&](const ScaleScore& score) {
      return score.candidate == ScaleCandidate{kRegressionMethod, at};
    });
  };
  const auto score = score_at(rung), twice = score_at(rung + kRungsToTwice);
  const bool falls =
      score != choice.scores.end() && twice != choice.scores.end() && score->noise > kLeastFall * twice->noise;
  return falls && AreErrorsIndependent(samples, rung + kRungsToTwice);
}

std::optional<DetailCheck> FindDetailCheck(PilotPoints samples, const ScaleChoice& choice) {
  const double least_error = LeastLocalError(choice);
  const auto check = std::find_if(choice.scores.begin(), choice.scores.end(), [&](const ScaleScore& score) {
    return score.candidate.method == kRegressionMethod && score.noise > 0.0 &&
           score.noise <= kMostNoiseOfCheck * least_error;
  });
  if (check == choice.scores.end() || check->candidate.rung >= FarthestThatCounts(choice)) return std::nullopt;
  // Jets of degree 4 have a bias of the same order.
  const bool are_jets_better = std::any_of(choice.scores.begin(), choice.scores.end(), [&](const ScaleScore& score) {
    return score.candidate == ScaleCandidate{kQuarticMethod, check->candidate.rung} && score.noise < check->noise;
  });
  if (are_jets_better || !DecidesNoise(samples, choice, check->candidate.rung)) return std::nullopt;
  return DetailCheck{check->candidate, check->noise};
}

}  // namespace curvd
