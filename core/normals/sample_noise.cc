#include "core/normals/sample_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/median.h"

namespace curvd {
namespace {

// Neighborhoods whose radius is less than this many standard deviations of the noise are balls of points more than
// pieces of a surface: nothing that is said of their fits holds.
constexpr double kLeastRadius = 5.0;
// A polynomial passes through all sites of a lattice that are within a few of its steps, on which the positions may
// lie.
constexpr double kLeastSteps = 4.0;
// Points of scan lines that are farther from one another than the points of one are have neighbors on few lines, or on
// one: by where these lie they determine no polynomial, but by their noise, which the fit then follows. Where the noise
// of a normal is more than so many times that of neighbors that fill a disc, and the noise is more than this share of
// the width that they have (squared), or where it is so many times more that nothing else makes it, the fit is
// undetermined. At the border of a surface the noise is 16 times that of a disc, in narrow strips up to 100 times.
constexpr double kDetermined = 30.0, kUndetermined = 300.0, kMostNoiseOfWidth = 0.05;
// Scales are unusable where more than this share of the fits is undetermined, but less of those of a larger scale: so
// it is where there are lines; in strips, and along wires, the larger scales are the undetermined ones.
constexpr double kMostUndetermined = 0.03;

// Whether the places of the neighbors determine the fit, and not the noise of that standard deviation.
bool IsDetermined(const SampleTable::Outcome& point, double sigma) {
  const double noise_of_width = point.excess * sigma * sigma / (static_cast<double>(point.radius) * point.radius);
  return point.excess <= kDetermined || (point.excess <= kUndetermined && noise_of_width <= kMostNoiseOfWidth);
}

// How many points have fits that their neighbors determine beyond doubt.
size_t DeterminedCount(const SampleView& view, size_t candidate) {
  size_t count = 0;
  for (size_t i = 0; i < view.sample_count(); ++i) {
    count += view.Counts(candidate, i) && view.outcome(candidate, i).excess <= kDetermined ? 1 : 0;
  }
  return count;
}

// Over the points that the candidate fits, and whose neighbors determine the fit if there are such: the median radius,
// and the median variance of the noise as its residuals show it; none where no point is fitted.
struct FitMedians {
  double radius;
  double variance;
};
std::optional<FitMedians> MediansOf(const SampleView& view, size_t candidate) {
  const double count = view.candidates()[candidate].count();
  const bool has_determined = DeterminedCount(view, candidate) > 0;
  std::vector<double> radii, variances;
  for (size_t i = 0; i < view.sample_count(); ++i) {
    const SampleTable::Outcome& point = view.outcome(candidate, i);
    if (!view.Counts(candidate, i) || (has_determined && point.excess > kDetermined)) continue;
    radii.push_back(point.radius);
    const double freedom = view.table().FreedomAt(candidate, i);
    if (freedom > 0.0) variances.push_back(point.mean_square * count / freedom);
  }
  if (radii.empty() || variances.empty()) return std::nullopt;
  return FitMedians{Median(radii), Median(variances)};
}

// Over the groups.
double MedianFreedom(const SampleView& view, size_t candidate) {
  std::vector<double> freedoms;
  for (size_t i = 0; i < view.sample_count(); i += SampleTable::kPointsPerGroup)
    freedoms.push_back(view.table().FreedomAt(candidate, i));
  return Median(freedoms);
}

// The least radius of neighborhoods that are much larger than noise of that standard deviation, and than the lattice on
// which positions may lie.
double LeastRadiusOf(const SampleView& view, double sigma) {
  return std::max(kLeastRadius * sigma, kLeastSteps * view.table().lattice_step());
}

// Of the fits; 1 where there is none.
double UndeterminedShare(const SampleView& view, size_t candidate, double sigma) {
  double fitted = 0.0, undetermined = 0.0;
  for (size_t i = 0; i < view.sample_count(); ++i) {
    if (!view.Counts(candidate, i)) continue;
    fitted += 1.0;
    undetermined += IsDetermined(view.outcome(candidate, i), sigma) ? 0.0 : 1.0;
  }
  return fitted > 0.0 ? undetermined / fitted : 1.0;
}

}  // namespace

// Bends add to the residuals, and the more, the more neighbors there are: the smallest neighborhoods count that are
// large beside the noise. In smaller ones the residual is that of a ball of points.
std::optional<double> SigmaOf(const SampleView& view) {
  const std::vector<SampleTable::Candidate>& candidates = view.candidates();
  constexpr double kLeastFreedom = 8.0;  // of the fit, for a median that means something
  if (candidates.empty()) return std::nullopt;
  const NormalMethod method = candidates.back().fit.method;
  size_t most_determined = 0;
  for (size_t c = 0; c < candidates.size(); ++c) {
    if (candidates[c].fit.method == method) most_determined = std::max(most_determined, DeterminedCount(view, c));
  }
  std::optional<double> sigma;
  for (size_t c = 0; c < candidates.size(); ++c) {
    if (candidates[c].fit.method != method || MedianFreedom(view, c) < kLeastFreedom) continue;
    if (2 * DeterminedCount(view, c) < most_determined) continue;
    const std::optional<FitMedians> medians = MediansOf(view, c);
    if (!medians.has_value()) continue;
    sigma = std::sqrt(medians->variance);
    if (medians->radius >= LeastRadiusOf(view, *sigma)) break;
  }
  return sigma;
}

bool IsLargeEnough(const SampleView& view, size_t candidate, double sigma) {
  const std::optional<FitMedians> medians = MediansOf(view, candidate);
  return medians.has_value() && medians->radius >= LeastRadiusOf(view, sigma);
}

bool IsMostlyDetermined(const SampleView& view, size_t candidate) {
  size_t fitted = 0;
  for (size_t i = 0; i < view.sample_count(); ++i) fitted += view.Counts(candidate, i) ? 1 : 0;
  const double undetermined = static_cast<double>(fitted - DeterminedCount(view, candidate));
  return undetermined <= kMostUndetermined * static_cast<double>(fitted);
}

bool CrossesTooFew(const SampleView& view, size_t candidate, double sigma) {
  const std::vector<SampleTable::Candidate>& candidates = view.candidates();
  if (UndeterminedShare(view, candidate, sigma) <= kMostUndetermined) return false;
  for (size_t c = candidate + 1; c < candidates.size(); ++c) {
    if (candidates[c].fit.method != candidates[candidate].fit.method) return false;
    if (UndeterminedShare(view, c, sigma) <= kMostUndetermined) return true;
  }
  return false;
}

bool SeesLines(const SampleView& view, double sigma) {
  for (size_t c = 0; c < view.candidates().size(); ++c) {
    if (CrossesTooFew(view, c, sigma)) return true;
  }
  return false;
}

}  // namespace curvd
