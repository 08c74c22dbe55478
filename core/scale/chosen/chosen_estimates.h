// Estimates points by all that was chosen for a cloud, and averages what each of them finds.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "core/estimators/curvature_field.h"
#include "core/estimators/options.h"
#include "core/estimators/strategy.h"
#include "core/index/spatial_index.h"
#include "core/scale/chosen/automatic_scratch.h"
#include "core/scale/edges/edge_run.h"
#include "core/scale/parts/cloud_choice.h"
#include "core/scale/parts/cloud_weights.h"

namespace curvd {

// The estimates of CloudChoice::chosen, in that order. For the points of a group: Start; Run one estimate after the
// other, and Add what it has written to the results; then Blended says what a point gets, but for those that are
// estimated from one side of an edge. EstimateGroup does that with all that count somewhere in the group. Const methods
// are thread-safe for distinct groups and scratch.
class ChosenEstimates {
 public:
  // Everything outlives the object. `edges`: null where nobody minds them; REQUIRES: it is finished, and LookAmong was
  // not called. REQUIRES: each part has chosen candidates.
  ChosenEstimates(const EstimatorOptions& options, const SpatialIndex& index, const CloudChoice& choice, EdgeRun* edges,
                  PointCurvature* results);

  // The places of the estimates but for checks of detail, the smallest neighborhood first.
  const std::vector<size_t>& by_count() const { return by_count_; }
  // Whether some neighborhoods are smaller than others.
  bool HaveSmallerOnes() const;

  // Averages what all that count find at the points of a group, from s.first_point on, as far as they come in a run of
  // their own: s.points ends there. An estimate counts in a group if its weight, in one of the quantities, is at least
  // kLeastWeight of all, or kLeastWeightOfExact, and at points where none of those finds a curvature, all of the part
  // do. Points of the first part whose estimates differ too much to be of that part go to the second one. One that
  // counts at no point is not made. Points beside seams are marked in s.seams. Errors as those of GroupPhase::run.
  static constexpr double kLeastWeight = 0.1, kLeastWeightOfExact = 0.25;
  absl::Status EstimateGroup(size_t group, AutomaticScratch& s) const;
  // Marks points of the group in s.has_detail whose averages smaller neighborhoods contradict. Errors as those of
  // GroupPhase::run.
  absl::Status LookForDetail(size_t group, AutomaticScratch& s) const;

  // Loads the points of a group, from s.first_point on, with their weights, and forgets the group before.
  void Start(size_t group, AutomaticScratch& s) const;
  // Estimates the group by one of them; s.rest is then that of the shortest run since Start, and s.points ends with it.
  // Errors as those of GroupPhase::run.
  absl::Status Run(size_t group, size_t estimate, SeamMarks* seams, AutomaticScratch& s) const;
  // Whether the estimate was chosen for the part of the cloud that the point of the group belongs to.
  bool IsOfPart(size_t point, size_t estimate, const AutomaticScratch& s) const;
  // Adds what one of them finds at a point to its averages.
  void Add(PointCurvature found, size_t point, size_t estimate, AutomaticScratch& s) const;
  static PointCurvature Blended(const AutomaticScratch& s, size_t point) {
    return IsOneSided(s, point) ? s.blends[point].Finish() : s.ClearBlend(point).Finish();
  }

  // Whether what was to count most at a point reaches over an edge.
  static bool IsOneSided(const AutomaticScratch& s, size_t point) {
    return s.ClearBlend(point).weight() < kLeastClearShare * s.blends[point].weight();
  }
  // Estimates those points of the group from their side of the edge. Errors as those of GroupPhase::run.
  absl::Status EstimateOneSided(size_t group, AutomaticScratch& s) const;

 private:
  // Of the weights at a point, so many must belong to estimates that reach over no edge.
  static constexpr double kLeastClearShare = 0.1;

  static bool Counts(size_t point, size_t estimate, const AutomaticScratch& s);
  // Which points of the first part have neighborhoods that reach into the second, as far as estimates tell. They belong
  // to the second from now on, and have no estimates. Errors as those of GroupPhase::run.
  absl::Status GiveToSecondPart(size_t group, AutomaticScratch::OfPoints<bool>& is_given, AutomaticScratch& s) const;
  // Neighbors of a point, in the mean over what its average is made of.
  double MeanCount(size_t point, const AutomaticScratch& s) const;
  // Of what is chosen for a part, in the caller's unit.
  double LeastError(size_t part) const;
  // Whether a neighborhood of the group, as that estimate has found them, holds a normal opposed to the point's own.
  static bool HoldOpposed(size_t estimate, const AutomaticScratch& s);
  void StartWeights(size_t group, AutomaticScratch& s) const;
  uint32_t OneSideSearchCount() const;
  OneSideScale ScaleAt(const float* position, CloudWeights& weights) const;

  const EstimatorOptions& options_;
  const SpatialIndex& index_;
  const CloudChoice& choice_;
  const EdgeRun* const edges_;
  PointCurvature* const results_;
  std::vector<std::unique_ptr<StrategyRun>> runs_;
  std::vector<GroupPhase> phases_;  // of each, the only one
  std::vector<size_t> by_count_;
  // Of each part: what estimates of exact positions differ by at most, unless they contradict each other.
  std::array<double, CloudChoice::kMostParts> most_spread_{};
  size_t marker_;  // of all estimates and checks, the one with the smallest neighborhoods: it looks for seams
};

}  // namespace curvd
