// Where one part of a cloud is much noisier than the other, each gets a scale of its own.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/median.h"
#include "core/normals/normal_fit.h"
#include "core/normals/runs/half_normals.h"
#include "core/normals/scale_pilot.h"

namespace curvd {
namespace {

// A smaller sample, or part of it, does not tell.
constexpr size_t kFewestGroups = 32;
constexpr double kLeastPart = 0.08;
// Parts differ if the median variance of one is so many times that of the other.
constexpr double kLeastRatio = 9.0;
// Nor are they parts of unlike density, whose neighborhoods reach from one into the other: median radii differ by less.
constexpr double kMostOfRadius = 2.0;
// Noise stays what it is when the neighbors are four times as many; what bends leave of a quadric grows.
constexpr double kMostGrowth = 3.0;
constexpr size_t kRungsToFourTimes = 4;
// With so many neighbors it is looked for, since steps of positions on a lattice are noise to large neighborhoods
// alone.
constexpr uint32_t kProbes[] = {48, 96, 192};
// What rounding leaves of coordinates of 1, squared.
constexpr double kRounding = 0x1p-46;
// It is that of the largest coordinates, but for those of a few groups: one point far from all others makes the index's
// unit so large that the rest of the cloud has small ones.
constexpr double kMostCoordinates = 0.9;

// What rounding leaves of the coordinates of these groups, squared.
double RoundingOf(const SpatialIndex& index, const std::vector<size_t>& groups) {
  std::vector<double> largest;
  for (const size_t group : groups) {
    const SpatialIndex::LeafPositions& points = index.positions(group * SpatialIndex::kGroupLeaves);
    largest.push_back(std::max({std::abs(points.x[0]), std::abs(points.y[0]), std::abs(points.z[0])}));
  }
  const auto at = static_cast<std::ptrdiff_t>(kMostCoordinates * static_cast<double>(largest.size()));
  std::nth_element(largest.begin(), largest.begin() + at, largest.end());
  int exponent = 0;
  std::frexp(largest[static_cast<size_t>(at)], &exponent);
  return std::ldexp(kRounding, 2 * exponent);
}

// Where to part values in ascending order so that the variance between both parts is the largest; none of them has
// fewer than `least`.
size_t SplitOf(const std::vector<double>& sorted, size_t least) {
  const double total = std::accumulate(sorted.begin(), sorted.end(), 0.0), size = static_cast<double>(sorted.size());
  double sum = 0.0, most = -1.0;
  size_t best = least;
  for (size_t i = 0; i + least <= sorted.size(); ++i) {
    if (i >= least) {
      const double below = static_cast<double>(i), above = size - below;
      const double difference = sum / below - (total - sum) / above, between = below * above * difference * difference;
      if (between > most) {
        most = between;
        best = i;
      }
    }
    sum += sorted[i];
  }
  return best;
}

}  // namespace

std::vector<double> ScalePilot::GroupVariances(size_t candidate) const {
  std::vector<double> variances;
  for (size_t group = 0; group < groups_.size(); ++group) {
    std::vector<double> of_points;
    for (size_t i = group * kPointsPerGroup; i < (group + 1) * kPointsPerGroup; ++i) {
      if (outcome(candidate, i).is_fitted) of_points.push_back(outcome(candidate, i).mean_square);
    }
    variances.push_back(of_points.empty() ? 0.0 : Median(of_points));
  }
  return variances;
}

double ScalePilot::RadiusOf(size_t candidate, const Parts& parts, bool noisy) const {
  std::vector<double> radii;
  for (size_t i = 0; i < sample_count(); ++i) {
    const bool counts = outcome(candidate, i).is_fitted && parts.is_noisy[i / kPointsPerGroup] == noisy;
    if (counts) radii.push_back(outcome(candidate, i).radius);
  }
  return radii.empty() ? 0.0 : Median(radii);
}

std::optional<ScalePilot::Parts> ScalePilot::PartsBy(size_t candidate) const {
  const size_t larger = candidate + kRungsToFourTimes;
  if (larger >= candidates_.size() || candidates_[larger].fit.method != NormalMethod::kJet2) return std::nullopt;
  const std::vector<double> variances = GroupVariances(candidate), of_larger = GroupVariances(larger);
  std::vector<double> sorted = variances;  // their logarithms
  const double rounding = RoundingOf(index_, groups_);
  for (double& variance : sorted) variance = std::log(std::max(variance, rounding));
  std::sort(sorted.begin(), sorted.end());
  const auto least = static_cast<size_t>(std::ceil(kLeastPart * static_cast<double>(sorted.size())));
  const size_t split = SplitOf(sorted, least);
  const double below = sorted[split / 2], above = sorted[(split + sorted.size()) / 2];
  if (above - below < std::log(kLeastRatio)) return std::nullopt;
  Parts parts{.is_noisy = {},
              .variances = variances,
              .noises = {},
              .probe_count = candidates_[candidate].count(),
              .least_variance = std::exp(0.5 * (sorted[split - 1] + sorted[split])),
              .quiet_variance = std::exp(below),
              .noisy_share = 1.0 - static_cast<double>(split) / static_cast<double>(sorted.size())};
  std::vector<double> growths;
  for (size_t group = 0; group < variances.size(); ++group) {
    parts.is_noisy.push_back(variances[group] >= parts.least_variance);
    const double growth = of_larger[group] / variances[group];
    if (parts.is_noisy.back() && variances[group] > 0.0) growths.push_back(growth);
    const double freedom = FreedomAt(candidate, group * kPointsPerGroup);
    const bool is_known = growth <= kMostGrowth && freedom > 0.0;
    parts.noises.push_back(is_known ? variances[group] * candidates_[candidate].count() / freedom : 0.0);
  }
  if (growths.empty() || Median(growths) > kMostGrowth) return std::nullopt;
  const double radius_ratio = RadiusOf(candidate, parts, true) / RadiusOf(candidate, parts, false);
  if (!(radius_ratio <= kMostOfRadius && radius_ratio >= 1.0 / kMostOfRadius)) return std::nullopt;
  return parts;
}

// Whatever else parts their residuals: noise is told as it is where a scale is chosen.
bool ScalePilot::DifferInNoise(const Parts& parts) {
  LookAt(parts, true);
  const std::optional<double> noisy = Sigma();
  LookAt(parts, false);
  const std::optional<double> quiet = Sigma();
  LookAtAll();
  return noisy.has_value() && quiet.has_value() && *noisy * *noisy >= kLeastRatio * *quiet * *quiet;
}

std::optional<ScalePilot::Parts> ScalePilot::FindParts() {
  if (groups_.size() < kFewestGroups) return std::nullopt;
  for (size_t c = 0; c < candidates_.size(); ++c) {
    const bool is_probe =
        candidates_[c].fit.method == NormalMethod::kJet2 &&
        std::find(std::begin(kProbes), std::end(kProbes), candidates_[c].count()) != std::end(kProbes);
    if (!is_probe || !IsMostlyDetermined(c)) continue;
    if (std::optional<Parts> parts = PartsBy(c); parts.has_value() && DifferInNoise(*parts)) return parts;
  }
  return std::nullopt;
}

void ScalePilot::LookAt(const Parts& parts, bool noisy) {
  group_noises_ = parts.noises;
  share_ = noisy ? parts.noisy_share : 1.0 - parts.noisy_share;
  for (size_t c = 0; c < candidates_.size(); ++c) {
    const bool may_mix = !noisy && candidates_[c].count() > parts.probe_count;
    const std::vector<double> variances = may_mix ? GroupVariances(c) : std::vector<double>(groups_.size(), 0.0);
    for (size_t i = 0; i < sample_count(); ++i) {
      const size_t group = i / kPointsPerGroup;
      const bool is_mixed =
          variances[group] >= NoisyPart::kMixedRatio * std::max(parts.variances[group], parts.quiet_variance);
      outcome(c, i).part = parts.is_noisy[group] != noisy ? Part::kOther : is_mixed ? Part::kMixed : Part::kOwn;
    }
  }
}

void ScalePilot::LookAtAll() {
  group_noises_.clear();
  share_ = 1.0;
  for (Outcome& outcome : outcomes_) outcome.part = Part::kOwn;
}

bool ScalePilot::IsMostlyMixed(size_t candidate) const {
  size_t own = 0, mixed = 0;
  for (size_t i = 0; i < sample_count(); ++i) {
    own += outcome(candidate, i).part == Part::kOwn ? 1 : 0;
    mixed += outcome(candidate, i).part == Part::kMixed ? 1 : 0;
  }
  return mixed > own;
}

// Where parts are narrower than neighborhoods, the quiet one is left with so few neighbors that noise decides its
// normals. Those of many points of both parts then err less, and halves tell their noise.
bool ScalePilot::KeepsNoise(const NormalFit& fit) const {
  const uint32_t count = std::get<NeighborCount>(fit.neighborhood).count;
  return count < LeastNeighborCountOfHalves(fit.method) && NoiseOfOne(fit.method, count).value_or(0.0) > kNegligible;
}

ChosenScale ScalePilot::Choose() {
  const std::optional<Parts> parts = FindParts();
  if (!parts.has_value()) return MindEdges(ChooseOne());
  LookAt(*parts, true);
  const ChosenScale noisy = ChooseOne();
  LookAt(*parts, false);
  ChosenScale chosen = ChooseOne();
  const bool keeps_noise = KeepsNoise(chosen.fit);
  LookAtAll();
  if (keeps_noise) {
    group_noises_ = parts->noises;
    chosen = ChooseOne();
    group_noises_.clear();
    return MindEdges(chosen);
  }
  chosen.noisy_sigma = noisy.sigma;
  chosen.noisy_share = parts->noisy_share;
  chosen.squared_error = (1.0 - parts->noisy_share) * chosen.squared_error + parts->noisy_share * noisy.squared_error;
  chosen.fit.noisy_part = NoisyPart{.method = noisy.fit.method,
                                    .neighborhood = std::get<NeighborCount>(noisy.fit.neighborhood),
                                    .shares = noisy.fit.shares,
                                    .crosses_lines = noisy.fit.crosses_lines,
                                    .probe_count = parts->probe_count,
                                    .least_variance = parts->least_variance,
                                    .quiet_variance = parts->quiet_variance};
  return chosen;
}

std::optional<double> ScalePilot::NoiseOf(NormalMethod method, uint32_t neighbor_count) {
  const std::optional<Parts> parts = FindParts();
  if (!parts.has_value()) return NoiseOfOne(method, neighbor_count);
  LookAt(*parts, true);
  const std::optional<double> noisy = NoiseOfOne(method, neighbor_count);
  LookAt(*parts, false);
  const std::optional<double> quiet = NoiseOfOne(method, neighbor_count);
  LookAtAll();
  if (!quiet.has_value() || !noisy.has_value()) return NoiseOfOne(method, neighbor_count);
  return (1.0 - parts->noisy_share) * *quiet + parts->noisy_share * *noisy;
}

}  // namespace curvd
