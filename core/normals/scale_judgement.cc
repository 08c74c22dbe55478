// What the pilot's fits tell about noise, bends and scales.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/median.h"
#include "core/normals/scale_pilot.h"

namespace curvd {
namespace {

struct Weights {
  // Errors from bends count so much more than those from noise.
  double bends;
  // Of fits whose squared error is at most this many times the least, the cheapest of the highest degree is taken: its
  // bends, of which noise hides some, are least.
  double good_enough;
};
constexpr Weights WeightsFor(NormalAim aim) {
  return aim == NormalAim::kCurvature ? Weights{.bends = 3.0, .good_enough = 1.2}
                                      : Weights{.bends = 1.0, .good_enough = 1.1};
}
// Sampled differences above this quantile are cut down to it: edges of the surface are few.
constexpr double kClipQuantile = 0.95;
// Neighborhoods whose radius is less than this many standard deviations of the noise are balls of points more than
// pieces of a surface: nothing that is said of their fits holds.
constexpr double kLeastRadius = 5.0;
// A polynomial passes through all sites of a lattice that are within a few of its steps, on which the positions may
// lie.
constexpr double kLeastSteps = 4.0;
// Nor does it where more than this share of the normals turn by more than 60 degrees as the count doubles, and more
// than that many times the share of the calmest scale. Those of trees in a terrain do while neighborhoods are small;
// those of points that fill a volume do at every scale.
constexpr double kMostUnsettled = 0.01, kAboveCalmest = 1.5;
constexpr double kTurned = 1.0;  // the squared chord of 60 degrees
// Nor can it be chosen where it fails at more than this share of the points that others fit: of positions on a coarse
// lattice, small neighborhoods are too alike. A few failures say nothing, since large neighborhoods reach from what has
// no normal, such as a wire, to what has one.
constexpr double kMostLost = 0.25;

// Points of scan lines that are farther from one another than the points of one are have neighbors on few lines, or on
// one: by where these lie they determine no polynomial, but by their noise, which the fit then follows. Where the noise
// of a normal is more than so many times that of neighbors that fill a disc, and the noise is more than this share of
// the width that they have (squared), or where it is so many times more that nothing else makes it, the fit is
// undetermined. At the border of a surface the noise is 16 times that of a disc, in narrow strips up to 100 times.
constexpr double kDetermined = 30.0, kUndetermined = 300.0, kMostNoiseOfWidth = 0.05;
// Scales are unusable where more than this share of the fits is undetermined, but less of those of a larger scale: so
// it is where there are lines; in strips, and along wires, the larger scales are the undetermined ones.
constexpr double kMostUndetermined = 0.03;

struct Clipped {
  double mean;
  double standard_error;
};

// The mean of values that are cut down to their quantile kClipQuantile. REQUIRES: there are some.
Clipped ClippedMean(std::vector<double>& values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(kClipQuantile * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  const double most = *at;
  double sum = 0.0, squares = 0.0;
  for (const double value : values) {
    const double clipped = std::min(value, most);
    sum += clipped;
    squares += clipped * clipped;
  }
  const double size = static_cast<double>(values.size()), mean = sum / size;
  return {mean, std::sqrt(std::max(squares / size - mean * mean, 0.0) / size)};
}

// Between two lines, small angles alone.
double SquaredAngle(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  double minus = 0.0, plus = 0.0;
  for (size_t axis = 0; axis < 3; ++axis) {
    const double difference = static_cast<double>(a[axis]) - b[axis], sum = static_cast<double>(a[axis]) + b[axis];
    minus += difference * difference;
    plus += sum * sum;
  }
  return std::min(minus, plus);
}

// The power of rho with which the error of a jet's normal grows.
double BendOrder(NormalMethod method) {
  return method == NormalMethod::kJet4 ? 4.0 : method == NormalMethod::kJet2 ? 2.0 : 1.0;
}

}  // namespace

double ScalePilot::FreedomAt(size_t candidate, size_t sample) const {
  const int coefficients = JetSize(std::max(candidates_[candidate].plan.degree, 1));
  return candidates_[candidate].count() - coefficients * copies_[sample / kPointsPerGroup];
}

bool ScalePilot::IsDetermined(const Outcome& point, double sigma) {
  const double noise_of_width = point.excess * sigma * sigma / (static_cast<double>(point.radius) * point.radius);
  return point.excess <= kDetermined || (point.excess <= kUndetermined && noise_of_width <= kMostNoiseOfWidth);
}

size_t ScalePilot::DeterminedCount(size_t candidate) const {
  size_t count = 0;
  for (size_t i = 0; i < sample_count(); ++i) {
    const Outcome& point = outcome(candidate, i);
    count += point.ok() && point.excess <= kDetermined ? 1 : 0;
  }
  return count;
}

bool ScalePilot::IsMostlyDetermined(size_t candidate) const {
  size_t fitted = 0;
  for (size_t i = 0; i < sample_count(); ++i) fitted += outcome(candidate, i).ok() ? 1 : 0;
  const double undetermined = static_cast<double>(fitted - DeterminedCount(candidate));
  return undetermined <= kMostUndetermined * static_cast<double>(fitted);
}

std::optional<ScalePilot::Medians> ScalePilot::MediansOf(size_t candidate) const {
  const double count = candidates_[candidate].count();
  const bool has_determined = DeterminedCount(candidate) > 0;
  std::vector<double> radii, variances;
  for (size_t i = 0; i < sample_count(); ++i) {
    const Outcome& point = outcome(candidate, i);
    if (!point.ok() || (has_determined && point.excess > kDetermined)) continue;
    radii.push_back(point.radius);
    const double freedom = FreedomAt(candidate, i);
    if (freedom > 0.0) variances.push_back(point.mean_square * count / freedom);
  }
  if (radii.empty() || variances.empty()) return std::nullopt;
  return Medians{Median(radii), Median(variances)};
}

double ScalePilot::MedianFreedom(size_t candidate) const {
  std::vector<double> freedoms;
  for (size_t i = 0; i < sample_count(); i += kPointsPerGroup) freedoms.push_back(FreedomAt(candidate, i));
  return Median(freedoms);
}

// Bends add to the residuals, and the more, the more neighbors there are: the smallest neighborhoods count that are
// large beside the noise. In smaller ones the residual is that of a ball of points.
std::optional<double> ScalePilot::Sigma() const {
  constexpr double kLeastFreedom = 8.0;  // of the fit, for a median that means something
  const NormalMethod method = candidates_.back().fit.method;
  size_t most_determined = 0;
  for (size_t c = 0; c < candidates_.size(); ++c) {
    if (candidates_[c].fit.method == method) most_determined = std::max(most_determined, DeterminedCount(c));
  }
  std::optional<double> sigma;
  for (size_t c = 0; c < candidates_.size(); ++c) {
    if (candidates_[c].fit.method != method || MedianFreedom(c) < kLeastFreedom) continue;
    if (2 * DeterminedCount(c) < most_determined) continue;
    const std::optional<Medians> medians = MediansOf(c);
    if (!medians.has_value()) continue;
    sigma = std::sqrt(medians->variance);
    if (medians->radius >= LeastRadius(*sigma)) break;
  }
  return sigma;
}

double ScalePilot::LeastRadius(double sigma) const {
  return std::max(kLeastRadius * sigma, kLeastSteps * lattice_step_);
}

bool ScalePilot::IsLargeEnough(size_t candidate, double sigma) const {
  const std::optional<Medians> medians = MediansOf(candidate);
  return medians.has_value() && medians->radius >= LeastRadius(sigma);
}

std::optional<double> ScalePilot::UnsettledShare(size_t candidate) const {
  const size_t doubled = candidate + kRungsPerDoubling;
  if (doubled >= candidates_.size() || candidates_[doubled].fit.method != candidates_[candidate].fit.method) {
    return std::nullopt;
  }
  double both = 0.0, turned = 0.0;
  for (size_t i = 0; i < sample_count(); ++i) {
    const Outcome &a = outcome(candidate, i), &b = outcome(doubled, i);
    if (!a.ok() || !b.ok()) continue;
    both += 1.0;
    turned += SquaredAngle(a.normal, b.normal) > kTurned ? 1.0 : 0.0;
  }
  return both > 0.0 ? turned / both : 1.0;
}

double ScalePilot::MostUnsettled() const {
  double least = 1.0;
  for (size_t c = 0; c < candidates_.size(); ++c) {
    least = std::min(least, UnsettledShare(c).value_or(1.0));
  }
  return std::max(kMostUnsettled, kAboveCalmest * least);
}

double ScalePilot::UndeterminedShare(size_t candidate, double sigma) const {
  double fitted = 0.0, undetermined = 0.0;
  for (size_t i = 0; i < sample_count(); ++i) {
    const Outcome& point = outcome(candidate, i);
    if (!point.ok()) continue;
    fitted += 1.0;
    undetermined += IsDetermined(point, sigma) ? 0.0 : 1.0;
  }
  return fitted > 0.0 ? undetermined / fitted : 1.0;
}

bool ScalePilot::CrossesTooFew(size_t candidate, double sigma) const {
  if (UndeterminedShare(candidate, sigma) <= kMostUndetermined) return false;
  for (size_t c = candidate + 1; c < candidates_.size(); ++c) {
    if (candidates_[c].fit.method != candidates_[candidate].fit.method) return false;
    if (UndeterminedShare(c, sigma) <= kMostUndetermined) return true;
  }
  return false;
}

bool ScalePilot::SeesLines(double sigma) const {
  for (size_t c = 0; c < candidates_.size(); ++c) {
    if (CrossesTooFew(c, sigma)) return true;
  }
  return false;
}

size_t ScalePilot::FittedCount(size_t candidate) const {
  size_t fitted = 0;
  for (size_t i = 0; i < sample_count(); ++i) {
    const Outcome& point = outcome(candidate, i);
    fitted += point.is_fitted && point.part != Part::kOther ? 1 : 0;
  }
  return fitted;
}

std::vector<bool> ScalePilot::Usable(double sigma) const {
  size_t most_fitted = 0;
  for (size_t c = 0; c < candidates_.size(); ++c) most_fitted = std::max(most_fitted, FittedCount(c));
  const double least_fitted = (1.0 - kMostLost) * static_cast<double>(most_fitted);
  std::vector<bool> usable(candidates_.size());
  const double most_unsettled = MostUnsettled();
  bool is_settled = true;
  for (size_t c = 0; c < candidates_.size(); ++c) {
    const bool is_first = c == 0 || candidates_[c].fit.method != candidates_[c - 1].fit.method;
    // What is settled stays so: larger neighborhoods have more to average.
    if (is_first || !is_settled) is_settled = UnsettledShare(c).value_or(is_first ? 0.0 : 1.0) <= most_unsettled;
    usable[c] = is_settled && static_cast<double>(FittedCount(c)) >= least_fitted && !IsMostlyMixed(c) &&
                IsLargeEnough(c, sigma);
  }
  for (size_t c = 0; c < candidates_.size(); ++c) {
    usable[c] = usable[c] && !CrossesTooFew(c, sigma) && IsSmallEnough(candidates_[c]);
  }
  return usable;
}

double ScalePilot::NoiseAt(size_t sample, double sigma) const {
  const double of_group = group_noises_.empty() ? 0.0 : group_noises_[sample / kPointsPerGroup];
  return of_group > 0.0 ? of_group : sigma * sigma;
}

double ScalePilot::Noise(size_t candidate, double sigma) const {
  std::vector<double> noises;
  for (size_t i = 0; i < sample_count(); ++i) {
    if (outcome(candidate, i).ok()) noises.push_back(outcome(candidate, i).noise);
  }
  return noises.empty() ? std::numeric_limits<double>::infinity() : sigma * sigma * ClippedMean(noises).mean;
}

double ScalePilot::Bends(size_t small, size_t large, double sigma) const {
  // Noise explains this much more than it should: coordinates within the plane are noisy too, and balls cut off some of
  // the noise along the normal, so that sigma is found up to a tenth too small. Measured: 1.1 to 1.4.
  constexpr double kSlack = 1.25;
  std::vector<double> changes, noises;
  for (size_t i = 0; i < sample_count(); ++i) {
    const Outcome &a = outcome(small, i), &b = outcome(large, i);
    if (!a.ok() || !b.ok()) continue;
    changes.push_back(SquaredAngle(a.normal, b.normal));
    // An estimate of least squares from more neighbors does not vary with its difference to one from some of them.
    noises.push_back(NoiseAt(i, sigma) * std::max(a.noise - b.noise, 0.0f));
  }
  if (changes.empty()) return 0.0;
  const Clipped change = ClippedMean(changes);
  // The error grows as a power of the radius, hence of the root of the count.
  const double shrink = static_cast<double>(candidates_[small].count()) / candidates_[large].count();
  const double seen = 1.0 - std::pow(shrink, 0.5 * BendOrder(candidates_[large].fit.method));
  const double beyond = change.mean - kSlack * ClippedMean(noises).mean - 2.0 * change.standard_error;
  return std::max(beyond, 0.0) / (seen * seen);
}

double ScalePilot::ErrorOf(size_t candidate, double sigma, const std::vector<bool>& usable) const {
  const NormalMethod method = candidates_[candidate].fit.method;
  const double noise = Noise(candidate, sigma);
  const auto is_rung = [&](size_t c) {
    return c < candidates_.size() && candidates_[c].fit.method == method && usable[c];
  };
  double bends = 0.0;
  for (size_t large = candidate; is_rung(large); --large) {
    // What smaller neighborhoods show already is also in this one.
    for (const size_t step : {size_t{1}, size_t{2}, size_t{4}}) {
      if (large < step || !is_rung(large - step)) continue;
      bends = std::max(bends, Bends(large - step, large, sigma));
    }
    if (large == 0) break;
  }
  // What a larger one shows beyond doubt was there before, as much smaller as its power of the radius is.
  if (is_rung(candidate + 1)) {
    const double at_next = Bends(candidate, candidate + 1, sigma);
    const double shrink = static_cast<double>(candidates_[candidate].count()) / candidates_[candidate + 1].count();
    bends = std::max(bends, at_next * std::pow(shrink, BendOrder(method)));
  }
  return noise + WeightsFor(aim_).bends * bends;
}

bool ScalePilot::IsSmallEnough(const Candidate& candidate) const {
  return static_cast<double>(kLeastTimes * candidate.count()) <= share_ * static_cast<double>(index_.point_count());
}

const ScalePilot::Candidate& ScalePilot::LargestOf(NormalMethod method) const {
  const auto is_it = [&](const Candidate& candidate) { return candidate.fit.method == method; };
  auto largest = std::find_if(candidates_.begin(), candidates_.end(), is_it);
  for (auto candidate = largest; candidate != candidates_.end() && is_it(*candidate); ++candidate) {
    if (IsSmallEnough(*candidate)) largest = candidate;
  }
  return *largest;
}

bool ScalePilot::IsRather(const Candidate& a, const Candidate& b) {
  if (a.plan.degree != b.plan.degree) return a.plan.degree > b.plan.degree;
  return a.cost() < b.cost();
}

ChosenScale ScalePilot::ChooseOne() const {
  const std::optional<double> sigma = candidates_.empty() ? std::nullopt : Sigma();
  if (!sigma.has_value()) return fallback_;
  ChosenScale chosen = fallback_;
  const std::vector<bool> usable = Usable(*sigma);
  std::vector<double> errors;
  for (size_t c = 0; c < candidates_.size(); ++c) {
    errors.push_back(usable[c] ? ErrorOf(c, *sigma, usable) : std::numeric_limits<double>::infinity());
  }
  const double least = *std::min_element(errors.begin(), errors.end());
  const Candidate* cheapest = nullptr;
  for (size_t c = 0; c < candidates_.size(); ++c) {
    const bool is_good = errors[c] < std::numeric_limits<double>::infinity() &&
                         errors[c] <= std::max(WeightsFor(aim_).good_enough * least, kNegligible);
    if (is_good && (cheapest == nullptr || IsRather(candidates_[c], *cheapest))) cheapest = &candidates_[c];
  }
  chosen.fit = cheapest != nullptr ? cheapest->fit : LargestOf(candidates_.front().fit.method).fit;
  chosen.fit.max_neighbor_count = fallback_.fit.max_neighbor_count;
  chosen.fit.crosses_lines = SeesLines(*sigma);
  chosen.sigma = std::ldexp(*sigma, -index_.scale_exponent());
  if (cheapest != nullptr) chosen.squared_error = errors[static_cast<size_t>(cheapest - candidates_.data())];
  return chosen;
}

std::optional<double> ScalePilot::NoiseOfOne(NormalMethod method, uint32_t neighbor_count) const {
  const std::optional<double> sigma = candidates_.empty() ? std::nullopt : Sigma();
  if (!sigma.has_value()) return std::nullopt;
  // The slopes of planes have the noise of those of quadrics, where neighbors lie evenly around a point.
  const NormalMethod like = method == NormalMethod::kJet4 ? NormalMethod::kJet4 : NormalMethod::kJet2;
  const double wanted = std::log(neighbor_count);
  const auto distance = [&](const Candidate& candidate) { return std::abs(std::log(candidate.count()) - wanted); };
  std::optional<size_t> nearest;
  for (size_t c = 0; c < candidates_.size(); ++c) {
    if (candidates_[c].fit.method != like) continue;
    if (!nearest.has_value() || distance(candidates_[c]) < distance(candidates_[*nearest])) nearest = c;
  }
  if (!nearest.has_value()) return std::nullopt;
  // The variance falls with the number of neighbors and with the square of their radius.
  const double times = static_cast<double>(candidates_[*nearest].count()) / neighbor_count;
  return Noise(*nearest, *sigma) * times * times;
}

}  // namespace curvd
