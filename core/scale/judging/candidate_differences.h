// By how much the estimates of the automatic choice's candidates differ: from each other, and between the halves of a
// neighborhood (docs/numerics/automatic_choice.md).
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/estimators/scale_ladder.h"
#include "core/scale/judging/candidate_values.h"
#include "core/scale/judging/growing_bias.h"
#include "core/scale/pilot/pilot_table.h"

namespace curvd {

// In one quantity, at the sampled points of a cloud. Const methods are thread-safe. Lengths are in the index's unit.
class CandidateDifferences {
 public:
  using Quantity = CandidateValues::Quantity;

  // `table` outlives the object.
  CandidateDifferences(PilotPoints table, Quantity quantity);

  PilotPoints table() const { return table_; }
  Quantity quantity() const { return quantity_; }
  const CandidateValues& values() const { return values_; }
  double MedianRadius(size_t rung) const { return median_radii_[rung]; }
  // The least error that can be told at that scale.
  double Floor(size_t rung) const { return floors_[rung]; }

  // By how much the candidate's estimates, and those of the next larger scale, differ over the cloud, as an error. None
  // if too few points have both.
  std::optional<double> OfCloud(const ScaleCandidate& candidate) const {
    return of_cloud_[candidate.method][candidate.rung];
  }
  // The same, of a candidate that cannot be compared with a next one: what is told of the last one that can.
  double OfCloudWhereCompared(const ScaleCandidate& candidate) const {
    return *of_cloud_[candidate.method][ComparedRung(candidate)];
  }
  // The same at each sampled point; where a point has none, what is usual there.
  std::vector<double> AtPoints(const ScaleCandidate& candidate, PilotPoint::Part part = PilotPoint::kAll) const;

  // Whether the halves of neighborhoods, too, have estimates at nearly all points.
  bool HasHalves(const ScaleCandidate& candidate) const;
  // The variance of the candidate's estimates that noise makes, as halves show it; 0 without halves.
  double Variance(const ScaleCandidate& candidate) const { return variances_[candidate.method][candidate.rung]; }
  // The first rung of a method that tells a variance; kRungCount: none does.
  size_t FirstWithVariance(size_t method) const;
  // What the variance at that rung makes of a candidate with fewer neighbors, if noise makes it: it falls from there on
  // as that of noise does. 0 if it does not, or the candidate has halves of its own.
  double VarianceBeforeFirst(const ScaleCandidate& candidate) const;
  // What both halves of a neighborhood show beyond those of another candidate. None without halves.
  std::optional<CommonChange> CommonTo(const ScaleCandidate& candidate, const ScaleCandidate& other) const;
  // The mean of it, less what chance makes of it. None without halves.
  std::optional<double> CommonSquare(const ScaleCandidate& candidate, const ScaleCandidate& other) const;
  // The largest of them beside smaller neighborhoods.
  double CommonSquareBesideSmaller(const ScaleCandidate& candidate) const;
  // What the changes from scale to scale tell of a method's bias.
  GrowingBias FindGrowingBias(size_t method) const;

  // What it holds of each sampled point.
  static constexpr size_t BytesPerSample(Quantity quantity) { return CandidateValues::BytesPerSample(quantity); }

 private:
  // The rung itself, unless it has no next one to be compared with.
  size_t ComparedRung(const ScaleCandidate& candidate) const;
  // Of the points whose neighborhoods at that rung reach over no edge.
  bool IsEnough(size_t count, double share, size_t rung) const;
  bool HasEstimates(const ScaleCandidate& candidate) const;
  double FloorAt(size_t rung) const;
  double VarianceOf(const ScaleCandidate& candidate) const;
  // By how much estimates differ from those so many rungs on, as an error.
  std::optional<double> MedianDifference(const ScaleCandidate& candidate, size_t step) const;
  // The last rungs have no next one to be compared with: their differences go on as those of single steps do.
  void AddLastDifferences(size_t method);

  const PilotPoints table_;
  const Quantity quantity_;
  const CandidateValues values_;
  std::array<size_t, kRungCount> clear_counts_{};  // of points whose neighborhoods reach over no edge
  std::array<double, kRungCount> median_radii_, floors_;
  std::optional<double> of_cloud_[kMethodCount][kRungCount];
  double variances_[kMethodCount][kRungCount] = {};
  size_t last_compared_[kMethodCount] = {};  // the last rung that has a next one
};

}  // namespace curvd
