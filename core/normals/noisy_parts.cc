#include "core/normals/noisy_parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numeric>
#include <utility>

#include "core/base/median.h"
#include "core/base/quantile.h"
#include "core/normals/normal_fit.h"
#include "core/normals/sample_noise.h"

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
constexpr size_t kRungsToFourTimes = 2 * SampleTable::kRungsPerDoubling;
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
  int exponent = 0;
  std::frexp(Quantile(largest, kMostCoordinates), &exponent);
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

// Of the groups, the median over their points of the variance of the residuals of a candidate; 0 where it fits none.
std::vector<double> GroupVariances(const SampleTable& table, size_t candidate) {
  std::vector<double> variances;
  for (size_t group = 0; group < table.groups().size(); ++group) {
    std::vector<double> of_points;
    for (size_t i = group * SampleTable::kPointsPerGroup; i < (group + 1) * SampleTable::kPointsPerGroup; ++i) {
      if (table.outcome(candidate, i).is_fitted) of_points.push_back(table.outcome(candidate, i).mean_square);
    }
    variances.push_back(of_points.empty() ? 0.0 : Median(of_points));
  }
  return variances;
}

// The median radius of a part's neighborhoods; 0 for none.
double RadiusOf(const SampleTable& table, size_t candidate, const SampleParts& parts, bool noisy) {
  std::vector<double> radii;
  for (size_t i = 0; i < table.sample_count(); ++i) {
    const bool counts =
        table.outcome(candidate, i).is_fitted && parts.is_noisy[i / SampleTable::kPointsPerGroup] == noisy;
    if (counts) radii.push_back(table.outcome(candidate, i).radius);
  }
  return radii.empty() ? 0.0 : Median(radii);
}

// How the fits of a candidate, of degree 2, part the sample; none where they do not, or where its bends do.
std::optional<SampleParts> PartsBy(const SampleTable& table, size_t candidate) {
  const std::vector<SampleTable::Candidate>& candidates = table.candidates();
  const size_t larger = candidate + kRungsToFourTimes;
  if (larger >= candidates.size() || candidates[larger].fit.method != NormalMethod::kJet2) return std::nullopt;
  const std::vector<double> variances = GroupVariances(table, candidate), of_larger = GroupVariances(table, larger);
  std::vector<double> sorted = variances;  // their logarithms
  const double rounding = RoundingOf(table.index(), table.groups());
  for (double& variance : sorted) variance = std::log(std::max(variance, rounding));
  std::sort(sorted.begin(), sorted.end());
  const auto least = static_cast<size_t>(std::ceil(kLeastPart * static_cast<double>(sorted.size())));
  const size_t split = SplitOf(sorted, least);
  const double below = sorted[split / 2], above = sorted[(split + sorted.size()) / 2];
  if (above - below < std::log(kLeastRatio)) return std::nullopt;
  SampleParts parts{.is_noisy = {},
                    .variances = variances,
                    .noises = {},
                    .probe_count = candidates[candidate].count(),
                    .least_variance = std::exp(0.5 * (sorted[split - 1] + sorted[split])),
                    .quiet_variance = std::exp(below),
                    .noisy_share = 1.0 - static_cast<double>(split) / static_cast<double>(sorted.size())};
  std::vector<double> growths;
  for (size_t group = 0; group < variances.size(); ++group) {
    parts.is_noisy.push_back(variances[group] >= parts.least_variance);
    const double growth = of_larger[group] / variances[group];
    if (parts.is_noisy.back() && variances[group] > 0.0) growths.push_back(growth);
    const double freedom = table.FreedomAt(candidate, group * SampleTable::kPointsPerGroup);
    const bool is_known = growth <= kMostGrowth && freedom > 0.0;
    parts.noises.push_back(is_known ? variances[group] * candidates[candidate].count() / freedom : 0.0);
  }
  if (growths.empty() || Median(growths) > kMostGrowth) return std::nullopt;
  const double radius_ratio = RadiusOf(table, candidate, parts, true) / RadiusOf(table, candidate, parts, false);
  if (!(radius_ratio <= kMostOfRadius && radius_ratio >= 1.0 / kMostOfRadius)) return std::nullopt;
  return parts;
}

// Whatever else parts their residuals: noise is told as it is where a scale is chosen.
bool DifferInNoise(const SampleTable& table, const SampleParts& parts) {
  const std::optional<double> noisy = SigmaOf(ViewOf(table, parts, true));
  const std::optional<double> quiet = SigmaOf(ViewOf(table, parts, false));
  return noisy.has_value() && quiet.has_value() && *noisy * *noisy >= kLeastRatio * *quiet * *quiet;
}

}  // namespace

std::optional<SampleParts> FindParts(const SampleTable& table) {
  if (table.groups().size() < kFewestGroups) return std::nullopt;
  const SampleView all(table);
  for (size_t c = 0; c < table.candidates().size(); ++c) {
    const SampleTable::Candidate& candidate = table.candidates()[c];
    const bool is_probe = candidate.fit.method == NormalMethod::kJet2 &&
                          std::find(std::begin(kProbes), std::end(kProbes), candidate.count()) != std::end(kProbes);
    if (!is_probe || !IsMostlyDetermined(all, c)) continue;
    std::optional<SampleParts> parts = PartsBy(table, c);
    if (parts.has_value() && DifferInNoise(table, *parts)) return parts;
  }
  return std::nullopt;
}

SampleView ViewOf(const SampleTable& table, const SampleParts& parts, bool noisy) {
  std::vector<SampleView::Part> of_outcomes;
  of_outcomes.reserve(table.candidates().size() * table.sample_count());
  for (size_t c = 0; c < table.candidates().size(); ++c) {
    const bool may_mix = !noisy && table.candidates()[c].count() > parts.probe_count;
    const std::vector<double> variances =
        may_mix ? GroupVariances(table, c) : std::vector<double>(table.groups().size(), 0.0);
    for (size_t i = 0; i < table.sample_count(); ++i) {
      const size_t group = i / SampleTable::kPointsPerGroup;
      const bool is_mixed =
          variances[group] >= NoisyPart::kMixedRatio * std::max(parts.variances[group], parts.quiet_variance);
      of_outcomes.push_back(parts.is_noisy[group] != noisy ? SampleView::Part::kOther
                            : is_mixed                     ? SampleView::Part::kMixed
                                                           : SampleView::Part::kOwn);
    }
  }
  return {table, std::move(of_outcomes), noisy ? parts.noisy_share : 1.0 - parts.noisy_share, parts.noises};
}

}  // namespace curvd
