// Chooses, from estimates at sampled points, by which estimators and at which scales a cloud is estimated, and with
// which weight each counts at each point (docs/numerics/automatic_choice.md).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/estimators/scale_ladder.h"
#include "core/scale/of_quantities.h"
#include "core/scale/pilot/pilot_table.h"

namespace curvd {

// What one candidate's mean curvature is expected to be off by, in units of 1 / the index's length.
struct ScaleScore {
  ScaleCandidate candidate;
  double error;               // all of it
  double difference;          // from the next larger scale, as it is found at the sampled points
  double noise;               // what differs between the halves of a neighborhood
  double bias;                // what is told of detail that is smoothed away
  double share = 0.0;         // mean weight in the mean curvature over the sampled points; 0: not among the chosen
  bool is_bias_known = true;  // else it was not looked for, as the rest of the error is far above the least
  // How many times its change to the next scale the bias is, as changes grow from scale to scale; 0: they do not tell.
  double bias_per_change = 0.0;
};

// Which candidates may be chosen.
struct ScaleBounds {
  MethodSet methods = AllMethods();
  uint32_t least_count = kScaleRungs.front();
  uint32_t most_count = kScaleRungs.back();
  float most_radius = std::numeric_limits<float>::infinity();  // of the median neighborhood
  bool per_cloud = false;                                      // the same weights at every point
};

// How the expected errors of one chosen candidate change from place to place.
struct LocalTrend {
  double cloud_error;       // over the whole cloud
  double cloud_difference;  // from the next larger scale, as it is found at the sampled points
  // From 0, differences change from place to place no more than chance makes them, to 1: what chance adds is nothing
  // beside how they change.
  double reliance;

  // The error where sampled points nearby show this mean difference.
  double ErrorAt(double difference) const;
};

// How much the estimates of one quantity by the chosen candidates count. All lists are in the order of
// ScaleChoice::chosen.
struct ScaleWeights {
  static constexpr size_t kMostChosen = 5;

  std::vector<double> cloud_weights;  // over the whole cloud; their sum is 1
  std::vector<LocalTrend> trends;     // empty: cloud_weights hold everywhere
  // By how much the estimates of each chosen candidate, and its next larger scale, differ at each sampled point.
  std::vector<std::array<float, kMostChosen>> local_differences;

  size_t bytes() const { return local_differences.capacity() * sizeof(local_differences.front()); }
};

// Candidates whose estimates are averaged, and how the weights change from place to place.
struct ScaleChoice {
  static constexpr size_t kMostChosen = ScaleWeights::kMostChosen;
  // Sampled points that the weights at a point are taken from.
  static constexpr size_t kNearest = 24;

  std::vector<ScaleScore> scores;  // of all candidates that could be judged
  // At most kMostChosen: first those with the largest shares in H and G, then what adds most to them; empty: none could
  // be judged.
  std::vector<ScaleCandidate> chosen;
  // Those of the traceless part are those of the mean curvature, without trends, where it would gain little by others.
  OfQuantities<ScaleWeights> weights;
  double sigma = 0.0;  // standard deviation of the positions' noise, in the index's unit, as the residuals show it
};

// Which candidates, before some are chosen, have at least some part of the weights in one of the quantities at one of
// the points.
struct CandidatesThatCount {
  size_t largest_rung = 0;
  MethodSet methods{};
};

// Nothing if no candidate can be judged.
std::optional<CandidatesThatCount> FindCandidatesThatCount(PilotPoints table, const ScaleBounds& bounds,
                                                           double least_weight);

// Thread-safe. The same table gives the same choice on every machine.
ScaleChoice ChooseScales(PilotPoints table, const ScaleBounds& bounds);

// The least error that is expected of what is chosen; where a method is that may look all around a body, of any
// candidate of the others, if there is one: fits to fewer neighbors need not err as little.
double LeastLocalError(const ScaleChoice& choice);

// What two errors come to that are independent. That of the traceless part is taken together with that of the mean
// curvature: where an estimate loses the one, the other is seldom right.
double AddedError(double error, double other);

// The weight of an estimate with this expected error.
double ScaleWeight(double error);

}  // namespace curvd
