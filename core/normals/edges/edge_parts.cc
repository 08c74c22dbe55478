#include "core/normals/edges/edge_parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/quantile.h"
#include "core/normals/normal_fit.h"
#include "core/normals/sample_noise.h"
#include "core/normals/sample_view.h"
#include "core/normals/scale_judgement.h"

namespace curvd {
namespace {

// So many rungs of the ladder lie between a number of neighbors and a half, or a quarter, of it.
constexpr size_t kRungsToHalf = SampleTable::kRungsPerDoubling, kRungsToQuarter = 2 * kRungsToHalf;
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

// Whether a candidate's fit of a sampled point leaves more of the heights than noise of that standard deviation does.
bool LeavesMore(const SampleTable& table, size_t candidate, size_t sample, double sigma) {
  const double freedom = std::max(table.FreedomAt(candidate, sample), 1.0);
  const double noise = sigma * sigma * freedom / table.candidates()[candidate].count();
  return !(table.outcome(candidate, sample).mean_square <= noise * EdgePart::MostOfNoise(freedom));
}

// Of the fits: those that leave more; 1 where there is none.
double CrossingShare(const SampleTable& table, size_t candidate, double sigma) {
  double fitted = 0.0, crossing = 0.0;
  for (size_t i = 0; i < table.sample_count(); ++i) {
    if (!table.outcome(candidate, i).is_fitted) continue;
    fitted += 1.0;
    crossing += LeavesMore(table, candidate, i, sigma) ? 1.0 : 0.0;
  }
  return fitted > 0.0 ? crossing / fitted : 1.0;
}

// How many times as large a variance of noise four times as many neighbors show, at points where a candidate's fit
// leaves more than noise does, in the median; 1 where there is no such point.
double CrossingGrowth(const SampleTable& table, size_t candidate, double sigma) {
  const size_t larger = candidate + kRungsToQuarter;
  std::vector<double> growths;
  for (size_t i = 0; i < table.sample_count(); ++i) {
    const SampleTable::Outcome &small = table.outcome(candidate, i), &large = table.outcome(larger, i);
    if (!small.is_fitted || !large.is_fitted || !LeavesMore(table, candidate, i, sigma)) continue;
    const double of_small =
        small.mean_square * table.candidates()[candidate].count() / std::max(table.FreedomAt(candidate, i), 1.0);
    const double of_large =
        large.mean_square * table.candidates()[larger].count() / std::max(table.FreedomAt(larger, i), 1.0);
    growths.push_back(of_large / of_small);
  }
  return growths.empty() ? 1.0 : Quantile(growths, 0.5);
}

// Whether edges are why fits of a candidate leave more than noise does, and why not all of them do. `fewest` is the
// least of the method that is much larger than noise. REQUIRES: it has a quarter of the neighbors or less.
bool CrossesEdges(const SampleTable& table, size_t candidate, size_t fewest, double sigma) {
  const double all = CrossingShare(table, candidate, sigma);
  if (all < kLeastCrossing || all > 1.0 - kLeastOfFaces) return false;
  const size_t quarter = candidate - kRungsToQuarter;
  const double of_half = CrossingShare(table, candidate - kRungsToHalf, sigma),
               of_quarter = CrossingShare(table, quarter, sigma);
  if (of_half < kLeastCrossingOfHalf * all) return false;
  if (of_quarter < kLeastCrossingOfQuarter * all || of_quarter > kMostCrossingOfQuarter * all) return false;
  std::vector<double> on_faces;
  for (size_t i = 0; i < table.sample_count(); ++i) {
    const SampleTable::Outcome& point = table.outcome(candidate, i);
    if (point.is_fitted && !LeavesMore(table, candidate, i, sigma))
      on_faces.push_back(point.mean_square / (sigma * sigma));
  }
  if (on_faces.empty() || Quantile(on_faces, 0.1) < kLeastTenth) return false;
  // Where noise differs, bends may add to it in large neighborhoods, but not in small ones.
  for (size_t small = fewest + 1; small < quarter; ++small) {
    const bool tells = CrossingShare(table, small, sigma) >= kLeastCrossing;
    if (tells && CrossingGrowth(table, small, sigma) < kLeastGrowthOfEdges) return false;
  }
  const double growth = CrossingGrowth(table, quarter, sigma);
  return growth >= kLeastGrowthOfEdges && growth <= kMostGrowthOfEdges;
}

// Those points of the sample whose fits leave no more than noise does.
SampleView FacesOf(const SampleTable& table, double sigma) {
  std::vector<SampleView::Part> parts;
  parts.reserve(table.candidates().size() * table.sample_count());
  for (size_t c = 0; c < table.candidates().size(); ++c) {
    for (size_t i = 0; i < table.sample_count(); ++i) {
      parts.push_back(LeavesMore(table, c, i, sigma) ? SampleView::Part::kMixed : SampleView::Part::kOwn);
    }
  }
  return {table, std::move(parts), 1.0, {}};
}

}  // namespace

ChosenFit MindEdges(const SampleTable& table, NormalAim aim, const ChosenFit& chosen) {
  const SampleView all(table);
  const std::vector<SampleTable::Candidate>& candidates = table.candidates();
  const std::optional<double> sigma = SigmaOf(all);
  if (!sigma.has_value() || !std::isfinite(chosen.squared_error) || chosen.fit.crosses_lines) return chosen;
  if (candidates.front().fit.method != NormalMethod::kJet2) return chosen;
  const std::vector<bool> usable = UsableCandidates(all, *sigma);
  const uint32_t chosen_count = std::get<NeighborCount>(chosen.fit.neighborhood).count;
  double least = std::numeric_limits<double>::infinity();
  std::optional<size_t> fewest;  // of those that are much larger than the noise
  std::vector<size_t> larger;
  for (size_t c = 0; c < candidates.size(); ++c) {
    const SampleTable::Candidate& candidate = candidates[c];
    const bool is_chosen = candidate.fit.method == chosen.fit.method && candidate.count() == chosen_count;
    if (is_chosen) least = kMuchLessError * NoiseOf(all, c, *sigma);
    if (candidate.fit.method != NormalMethod::kJet2) continue;
    if (!fewest.has_value() && IsLargeEnough(all, c, *sigma)) fewest = c;
    const bool may_be = usable[c] && !candidate.fit.shares && fewest.has_value() && c >= *fewest + kRungsToQuarter;
    if (may_be && CrossesEdges(table, c, *fewest, *sigma)) larger.push_back(c);
  }
  if (larger.empty()) return chosen;
  const SampleView faces = FacesOf(table, *sigma);
  std::optional<size_t> best;
  for (const size_t c : larger) {
    const double error = ErrorOf(faces, aim, c, *sigma, usable);
    if (!(error <= least)) continue;
    least = error;
    best = c;
  }
  if (!best.has_value()) return chosen;
  ChosenFit with_edges = chosen;
  with_edges.fit.method = NormalMethod::kJet2;
  with_edges.fit.neighborhood = candidates[*best].fit.neighborhood;
  with_edges.fit.shares = false;
  size_t beside = *fewest;
  while (beside + kRungsToQuarter < *best && !IsLargeEnough(all, beside, kTimesNoiseBeside * *sigma)) ++beside;
  with_edges.fit.edge_part = EdgePart{.neighborhood = std::get<NeighborCount>(candidates[beside].fit.neighborhood),
                                      .variance = *sigma * *sigma};
  return with_edges;
}

}  // namespace curvd
