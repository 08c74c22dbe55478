#include "core/normals/scale_judgement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "core/base/quantile.h"
#include "core/normals/sample_noise.h"

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
// Nothing that is said of the fits of a scale holds where more than this share of the normals turn by more than 60
// degrees as the count doubles, and more than that many times the share of the calmest scale. Those of trees in a
// terrain do while neighborhoods are small; those of points that fill a volume do at every scale.
constexpr double kMostUnsettled = 0.01, kAboveCalmest = 1.5;
constexpr double kTurned = 1.0;  // the squared chord of 60 degrees
// Nor can a scale be chosen that fails at more than this share of the points that others fit: of positions on a coarse
// lattice, small neighborhoods are too alike. A few failures say nothing, since large neighborhoods reach from what has
// no normal, such as a wire, to what has one.
constexpr double kMostLost = 0.25;

struct Clipped {
  double mean;
  double standard_error;
};

// The mean of values that are cut down to their quantile kClipQuantile. REQUIRES: there are some.
Clipped ClippedMean(std::vector<double>& values) {
  const double most = Quantile(values, kClipQuantile);
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

// The share of the normals that turn to elsewhere when the neighborhoods double. None where no candidate has twice the
// count.
std::optional<double> UnsettledShare(const SampleView& view, size_t candidate) {
  const std::vector<SampleTable::Candidate>& candidates = view.candidates();
  const size_t doubled = candidate + SampleTable::kRungsPerDoubling;
  if (doubled >= candidates.size() || candidates[doubled].fit.method != candidates[candidate].fit.method) {
    return std::nullopt;
  }
  double both = 0.0, turned = 0.0;
  for (size_t i = 0; i < view.sample_count(); ++i) {
    if (!view.Counts(candidate, i) || !view.Counts(doubled, i)) continue;
    both += 1.0;
    const double angle = SquaredAngle(view.outcome(candidate, i).normal, view.outcome(doubled, i).normal);
    turned += angle > kTurned ? 1.0 : 0.0;
  }
  return both > 0.0 ? turned / both : 1.0;
}

// The largest such share with which a scale is usable.
double MostUnsettled(const SampleView& view) {
  double least = 1.0;
  for (size_t c = 0; c < view.candidates().size(); ++c) {
    least = std::min(least, UnsettledShare(view, c).value_or(1.0));
  }
  return std::max(kMostUnsettled, kAboveCalmest * least);
}

// How many points of the part are fitted, with whatever neighbors.
size_t FittedCount(const SampleView& view, size_t candidate) {
  size_t fitted = 0;
  for (size_t i = 0; i < view.sample_count(); ++i) {
    const bool is_elsewhere = view.part(candidate, i) == SampleView::Part::kOther;
    fitted += view.outcome(candidate, i).is_fitted && !is_elsewhere ? 1 : 0;
  }
  return fitted;
}

// Whether most neighborhoods of the part reach out of it.
bool IsMostlyMixed(const SampleView& view, size_t candidate) {
  size_t own = 0, mixed = 0;
  for (size_t i = 0; i < view.sample_count(); ++i) {
    own += view.part(candidate, i) == SampleView::Part::kOwn ? 1 : 0;
    mixed += view.part(candidate, i) == SampleView::Part::kMixed ? 1 : 0;
  }
  return mixed > own;
}

// Whether the part has enough points for such neighborhoods.
bool IsSmallEnough(const SampleView& view, const SampleTable::Candidate& candidate) {
  return static_cast<double>(kLeastPointsPerNeighbor * candidate.count()) <=
         view.share() * static_cast<double>(view.table().index().point_count());
}

// The largest that are, or the smallest. REQUIRES: there is a candidate of the method.
const SampleTable::Candidate& LargestOf(const SampleView& view, NormalMethod method) {
  const std::vector<SampleTable::Candidate>& candidates = view.candidates();
  const auto is_it = [&](const SampleTable::Candidate& candidate) { return candidate.fit.method == method; };
  auto largest = std::find_if(candidates.begin(), candidates.end(), is_it);
  for (auto candidate = largest; candidate != candidates.end() && is_it(*candidate); ++candidate) {
    if (IsSmallEnough(view, *candidate)) largest = candidate;
  }
  return *largest;
}

// Whether `a` is to be taken where both are good enough.
bool IsRather(const SampleTable::Candidate& a, const SampleTable::Candidate& b) {
  if (a.plan.degree != b.plan.degree) return a.plan.degree > b.plan.degree;
  return a.cost() < b.cost();
}

// The squared error of the normals at `large` that bends make, as far as their change since `small` shows it beyond
// what noise explains.
double Bends(const SampleView& view, size_t small, size_t large, double sigma) {
  const std::vector<SampleTable::Candidate>& candidates = view.candidates();
  // Noise explains this much more than it should: coordinates within the plane are noisy too, and balls cut off some of
  // the noise along the normal, so that sigma is found up to a tenth too small. Measured: 1.1 to 1.4.
  constexpr double kSlack = 1.25;
  std::vector<double> changes, noises;
  for (size_t i = 0; i < view.sample_count(); ++i) {
    if (!view.Counts(small, i) || !view.Counts(large, i)) continue;
    const SampleTable::Outcome &a = view.outcome(small, i), &b = view.outcome(large, i);
    changes.push_back(SquaredAngle(a.normal, b.normal));
    // An estimate of least squares from more neighbors does not vary with its difference to one from some of them.
    noises.push_back(view.NoiseAt(i, sigma) * std::max(a.noise - b.noise, 0.0f));
  }
  if (changes.empty()) return 0.0;
  const Clipped change = ClippedMean(changes);
  // The error grows as a power of the radius, hence of the root of the count.
  const double shrink = static_cast<double>(candidates[small].count()) / candidates[large].count();
  const double seen = 1.0 - std::pow(shrink, 0.5 * BendOrder(candidates[large].fit.method));
  const double beyond = change.mean - kSlack * ClippedMean(noises).mean - 2.0 * change.standard_error;
  return std::max(beyond, 0.0) / (seen * seen);
}

}  // namespace

std::vector<bool> UsableCandidates(const SampleView& view, double sigma) {
  const std::vector<SampleTable::Candidate>& candidates = view.candidates();
  size_t most_fitted = 0;
  for (size_t c = 0; c < candidates.size(); ++c) most_fitted = std::max(most_fitted, FittedCount(view, c));
  const double least_fitted = (1.0 - kMostLost) * static_cast<double>(most_fitted);
  std::vector<bool> usable(candidates.size());
  const double most_unsettled = MostUnsettled(view);
  bool is_settled = true;
  for (size_t c = 0; c < candidates.size(); ++c) {
    const bool is_first = c == 0 || candidates[c].fit.method != candidates[c - 1].fit.method;
    // What is settled stays so: larger neighborhoods have more to average.
    if (is_first || !is_settled) is_settled = UnsettledShare(view, c).value_or(is_first ? 0.0 : 1.0) <= most_unsettled;
    usable[c] = is_settled && static_cast<double>(FittedCount(view, c)) >= least_fitted && !IsMostlyMixed(view, c) &&
                IsLargeEnough(view, c, sigma);
  }
  for (size_t c = 0; c < candidates.size(); ++c) {
    usable[c] = usable[c] && !CrossesTooFew(view, c, sigma) && IsSmallEnough(view, candidates[c]);
  }
  return usable;
}

double NoiseOf(const SampleView& view, size_t candidate, double sigma) {
  std::vector<double> noises;
  for (size_t i = 0; i < view.sample_count(); ++i) {
    if (view.Counts(candidate, i)) noises.push_back(view.outcome(candidate, i).noise);
  }
  return noises.empty() ? std::numeric_limits<double>::infinity() : sigma * sigma * ClippedMean(noises).mean;
}

double ErrorOf(const SampleView& view, NormalAim aim, size_t candidate, double sigma, const std::vector<bool>& usable) {
  const std::vector<SampleTable::Candidate>& candidates = view.candidates();
  const NormalMethod method = candidates[candidate].fit.method;
  const double noise = NoiseOf(view, candidate, sigma);
  const auto is_rung = [&](size_t c) {
    return c < candidates.size() && candidates[c].fit.method == method && usable[c];
  };
  double bends = 0.0;
  for (size_t large = candidate; is_rung(large); --large) {
    // What smaller neighborhoods show already is also in this one.
    for (const size_t step : {size_t{1}, size_t{2}, size_t{4}}) {
      if (large < step || !is_rung(large - step)) continue;
      bends = std::max(bends, Bends(view, large - step, large, sigma));
    }
    if (large == 0) break;
  }
  // What a larger one shows beyond doubt was there before, as much smaller as its power of the radius is.
  if (is_rung(candidate + 1)) {
    const double at_next = Bends(view, candidate, candidate + 1, sigma);
    const double shrink = static_cast<double>(candidates[candidate].count()) / candidates[candidate + 1].count();
    bends = std::max(bends, at_next * std::pow(shrink, BendOrder(method)));
  }
  return noise + WeightsFor(aim).bends * bends;
}

ChosenFit ChooseOne(const SampleView& view, NormalAim aim, const NormalFit& fallback) {
  const std::vector<SampleTable::Candidate>& candidates = view.candidates();
  ChosenFit chosen;
  chosen.fit = fallback;
  const std::optional<double> sigma = SigmaOf(view);
  if (!sigma.has_value()) return chosen;
  const std::vector<bool> usable = UsableCandidates(view, *sigma);
  std::vector<double> errors;
  for (size_t c = 0; c < candidates.size(); ++c) {
    errors.push_back(usable[c] ? ErrorOf(view, aim, c, *sigma, usable) : std::numeric_limits<double>::infinity());
  }
  const double least = *std::min_element(errors.begin(), errors.end());
  const SampleTable::Candidate* cheapest = nullptr;
  for (size_t c = 0; c < candidates.size(); ++c) {
    const bool is_good = errors[c] < std::numeric_limits<double>::infinity() &&
                         errors[c] <= std::max(WeightsFor(aim).good_enough * least, kNegligibleError);
    if (is_good && (cheapest == nullptr || IsRather(candidates[c], *cheapest))) cheapest = &candidates[c];
  }
  chosen.fit = cheapest != nullptr ? cheapest->fit : LargestOf(view, candidates.front().fit.method).fit;
  chosen.fit.max_neighbor_count = fallback.max_neighbor_count;
  chosen.fit.crosses_lines = SeesLines(view, *sigma);
  chosen.sigma = std::ldexp(*sigma, -view.table().index().scale_exponent());
  if (cheapest != nullptr) chosen.squared_error = errors[static_cast<size_t>(cheapest - candidates.data())];
  return chosen;
}

std::optional<double> NoiseOfFit(const SampleView& view, NormalMethod method, uint32_t neighbor_count) {
  const std::vector<SampleTable::Candidate>& candidates = view.candidates();
  const std::optional<double> sigma = SigmaOf(view);
  if (!sigma.has_value()) return std::nullopt;
  // The slopes of planes have the noise of those of quadrics, where neighbors lie evenly around a point.
  const NormalMethod like = method == NormalMethod::kJet4 ? NormalMethod::kJet4 : NormalMethod::kJet2;
  const double wanted = std::log(neighbor_count);
  const auto distance = [&](const SampleTable::Candidate& candidate) {
    return std::abs(std::log(candidate.count()) - wanted);
  };
  std::optional<size_t> nearest;
  for (size_t c = 0; c < candidates.size(); ++c) {
    if (candidates[c].fit.method != like) continue;
    if (!nearest.has_value() || distance(candidates[c]) < distance(candidates[*nearest])) nearest = c;
  }
  if (!nearest.has_value()) return std::nullopt;
  // The variance falls with the number of neighbors and with the square of their radius.
  const double times = static_cast<double>(candidates[*nearest].count()) / neighbor_count;
  return NoiseOf(view, *nearest, *sigma) * times * times;
}

}  // namespace curvd
