// Where edges of the surface make the scale small, points away from them get a larger one.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "core/normals/normal_fit.h"
#include "core/normals/scale_pilot.h"

namespace curvd {
namespace {

// So many rungs of the ladder lie between a number of neighbors and a half, or a quarter, of it.
constexpr size_t kRungsToHalf = 2, kRungsToQuarter = 4;
// Fewer points near edges than this share do no harm: what is sampled is clipped (scale_judgement.cc).
constexpr double kLeastCrossing = 0.08;
// Fewer points than this share would profit. Smooth surfaces and scans with detail everywhere leave fewer as well.
constexpr double kLeastOfFaces = 0.2;
// The points near edges are as many as the radius is large, so that half of the neighbors cross at 0.71 times as many
// points, and a quarter at 0.5 times; measured on solids: 0.5 to 0.85, and 0.15 (much noise hides edges from few
// neighbors) to 0.7. What bends smoothly leaves 64 times less of a quarter of the neighbors, so that hardly any do.
// Where noise differs from place to place, as many leave more of few neighbors as of many.
constexpr double kLeastCrossingOfHalf = 0.5, kLeastCrossingOfQuarter = 0.15, kMostCrossingOfQuarter = 0.85;
// At an edge, four times as many neighbors leave four times the variance: of points that lie in noise once, and 64
// times where they bend. Medians measured on solids: 1.3 (noise of 0.3 spacings) to 12.
constexpr double kLeastGrowthOfEdges = 1.25, kMostGrowthOfEdges = 12.0;
// Away from edges, what fits leave is noise of one variance: the lowest tenth is not below this share of it. Of noise
// alone it is 0.7 of 48 neighbors, and sigma is up to a tenth too large where many points lie near edges.
constexpr double kLeastTenth = 0.5;
// Normals are made of more neighbors if that halves their squared error, or more.
constexpr double kMuchLessError = 0.5;
// Neighborhoods of points beside edges are so many times larger beside the noise than fits need: a radius of 12.5
// sigma. Of fewer neighbors, with a noise of 0.18 spacings and more, a few normals lay so far off that the points
// around them were taken for opposed: up to 6 % of a solid.
constexpr double kTimesNoiseBeside = 2.5;

// The value that the share of the others is below. REQUIRES: there are values.
double QuantileOf(std::vector<double>& values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

bool ScalePilot::LeavesMore(size_t candidate, size_t sample, double sigma) const {
  const double freedom = std::max(FreedomAt(candidate, sample), 1.0);
  const double noise = sigma * sigma * freedom / candidates_[candidate].count();
  return !(outcome(candidate, sample).mean_square <= noise * EdgePart::MostOfNoise(freedom));
}

double ScalePilot::CrossingShare(size_t candidate, double sigma) const {
  double fitted = 0.0, crossing = 0.0;
  for (size_t i = 0; i < sample_count(); ++i) {
    if (!outcome(candidate, i).is_fitted) continue;
    fitted += 1.0;
    crossing += LeavesMore(candidate, i, sigma) ? 1.0 : 0.0;
  }
  return fitted > 0.0 ? crossing / fitted : 1.0;
}

double ScalePilot::CrossingGrowth(size_t candidate, double sigma) const {
  const size_t larger = candidate + kRungsToQuarter;
  std::vector<double> growths;
  for (size_t i = 0; i < sample_count(); ++i) {
    const Outcome &small = outcome(candidate, i), &large = outcome(larger, i);
    if (!small.is_fitted || !large.is_fitted || !LeavesMore(candidate, i, sigma)) continue;
    const double of_small = small.mean_square * candidates_[candidate].count() / std::max(FreedomAt(candidate, i), 1.0);
    const double of_large = large.mean_square * candidates_[larger].count() / std::max(FreedomAt(larger, i), 1.0);
    growths.push_back(of_large / of_small);
  }
  return growths.empty() ? 1.0 : QuantileOf(growths, 0.5);
}

bool ScalePilot::CrossesEdges(size_t candidate, size_t fewest, double sigma) const {
  const double all = CrossingShare(candidate, sigma);
  if (all < kLeastCrossing || all > 1.0 - kLeastOfFaces) return false;
  const size_t quarter = candidate - kRungsToQuarter;
  const double of_half = CrossingShare(candidate - kRungsToHalf, sigma), of_quarter = CrossingShare(quarter, sigma);
  if (of_half < kLeastCrossingOfHalf * all) return false;
  if (of_quarter < kLeastCrossingOfQuarter * all || of_quarter > kMostCrossingOfQuarter * all) return false;
  std::vector<double> on_faces;
  for (size_t i = 0; i < sample_count(); ++i) {
    const Outcome& point = outcome(candidate, i);
    if (point.is_fitted && !LeavesMore(candidate, i, sigma)) on_faces.push_back(point.mean_square / (sigma * sigma));
  }
  if (on_faces.empty() || QuantileOf(on_faces, 0.1) < kLeastTenth) return false;
  // Where noise differs, bends may add to it in large neighborhoods, but not in small ones.
  for (size_t small = fewest + 1; small < quarter; ++small) {
    const bool tells = CrossingShare(small, sigma) >= kLeastCrossing;
    if (tells && CrossingGrowth(small, sigma) < kLeastGrowthOfEdges) return false;
  }
  const double growth = CrossingGrowth(quarter, sigma);
  return growth >= kLeastGrowthOfEdges && growth <= kMostGrowthOfEdges;
}

void ScalePilot::LookAtFaces(double sigma) {
  for (size_t c = 0; c < candidates_.size(); ++c) {
    for (size_t i = 0; i < sample_count(); ++i) {
      outcome(c, i).part = LeavesMore(c, i, sigma) ? Part::kMixed : Part::kOwn;
    }
  }
}

ChosenScale ScalePilot::MindEdges(const ChosenScale& chosen) {
  const std::optional<double> sigma = candidates_.empty() ? std::nullopt : Sigma();
  if (!sigma.has_value() || !std::isfinite(chosen.squared_error) || chosen.fit.crosses_lines) return chosen;
  if (candidates_.front().fit.method != NormalMethod::kJet2) return chosen;
  const std::vector<bool> usable = Usable(*sigma);
  const uint32_t chosen_count = std::get<NeighborCount>(chosen.fit.neighborhood).count;
  double least = std::numeric_limits<double>::infinity();
  std::optional<size_t> fewest;  // of those that are much larger than the noise
  std::vector<size_t> larger;
  for (size_t c = 0; c < candidates_.size(); ++c) {
    const Candidate& candidate = candidates_[c];
    const bool is_chosen = candidate.fit.method == chosen.fit.method && candidate.count() == chosen_count;
    if (is_chosen) least = kMuchLessError * Noise(c, *sigma);
    if (candidate.fit.method != NormalMethod::kJet2) continue;
    if (!fewest.has_value() && IsLargeEnough(c, *sigma)) fewest = c;
    const bool may_be = usable[c] && !candidate.fit.shares && fewest.has_value() && c >= *fewest + kRungsToQuarter;
    if (may_be && CrossesEdges(c, *fewest, *sigma)) larger.push_back(c);
  }
  if (larger.empty()) return chosen;
  LookAtFaces(*sigma);
  std::optional<size_t> best;
  for (const size_t c : larger) {
    const double error = ErrorOf(c, *sigma, usable);
    if (!(error <= least)) continue;
    least = error;
    best = c;
  }
  LookAtAll();
  if (!best.has_value()) return chosen;
  ChosenScale with_edges = chosen;
  with_edges.fit.method = NormalMethod::kJet2;
  with_edges.fit.neighborhood = candidates_[*best].fit.neighborhood;
  with_edges.fit.shares = false;
  size_t beside = *fewest;
  while (beside + kRungsToQuarter < *best && !IsLargeEnough(beside, kTimesNoiseBeside * *sigma)) ++beside;
  with_edges.fit.edge_part = EdgePart{.neighborhood = std::get<NeighborCount>(candidates_[beside].fit.neighborhood),
                                      .variance = *sigma * *sigma};
  return with_edges;
}

}  // namespace curvd
