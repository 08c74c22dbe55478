// Judges by a table of estimates how far each way to estimate a cloud is off (docs/numerics/automatic_choice.md).
#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <vector>

#include "core/estimators/scale_ladder.h"
#include "core/scale/judging/candidate_values.h"
#include "core/scale/judging/lost_detail.h"
#include "core/scale/pilot/pilot_table.h"
#include "core/scale/scale_choice.h"

namespace curvd {

// Of one quantity. Const methods are thread-safe. Lengths are in the index's unit.
class ScaleJudge {
 public:
  using Quantity = CandidateValues::Quantity;

  // `table` outlives the object.
  ScaleJudge(PilotPoints table, const ScaleBounds& bounds, Quantity quantity);

  // Of all candidates that can be judged and are within the bounds, by method, then by rung. Not of the Gaussian
  // curvature.
  std::vector<ScaleScore> Scores() const;
  // The scores of candidates that another judge has judged by the mean curvature. Their biases are as large beside the
  // differences as there, at the least: noise in a small neighborhood moves the Gaussian curvature of both halves to
  // one side, as detail would.
  std::vector<ScaleScore> ScoresOf(const std::vector<ScaleScore>& of_mean, const ScaleJudge& judge_of_mean) const;

  // By how much the candidate's estimate, and that of the next larger scale, differ at each sampled point.
  std::vector<double> DifferencesAtPoints(const ScaleScore& score, PilotPoint::Part part = PilotPoint::kAll) const;
  // What the differences at points come to over the cloud.
  double CloudDifference(const ScaleScore& score) const {
    return *differences_[score.candidate.method][ComparedRung(score.candidate)];
  }
  // Whether the halves of neighborhoods, too, have estimates at nearly all points.
  bool HasHalves(const ScaleCandidate& candidate) const;

  // What it holds of each sampled point.
  static constexpr size_t BytesPerSample(Quantity quantity) {
    return CandidateValues::BytesPerSample(quantity) + LostDetail::kBytesPerSample;
  }

  // Standard deviation of the noise of positions; none if nothing tells it.
  static std::optional<double> PositionNoise(PilotPoints table);
  // Whether that is known to be nothing beside the smallest neighborhoods.
  static bool PositionsAreExact(PilotPoints table);
  double sigma() const { return sigma_; }
  // The least error that can be told at that scale.
  double Floor(size_t rung) const { return floors_[rung]; }

 private:
  // The rung itself, unless it has no next one to be compared with.
  size_t ComparedRung(const ScaleCandidate& candidate) const;

  double FloorAt(size_t rung) const;

  // Of the points whose neighborhoods at that rung reach over no edge.
  bool IsEnough(size_t count, double share, size_t rung) const;
  bool IsAllowed(const ScaleCandidate& candidate) const;
  bool HasEstimates(const ScaleCandidate& candidate) const;

  // How far the values of two candidates, or of one in two parts, lie apart, where they do.
  static std::vector<double> DistancesOf(const CandidateValues::Column& one, const CandidateValues::Column& other);
  // By how much estimates differ from those so many rungs on, as an error.
  std::optional<double> MedianDifference(const ScaleCandidate& candidate, size_t step) const;
  // The last rungs have no next one to be compared with: their differences go on as those of single steps do.
  void AddLastDifferences(size_t method);
  // Noise in the positions: how large, and what it does to an estimate of noise factor 1.
  void FindNoise();
  // The variance of the candidate's estimates that noise makes.
  double Variance(const ScaleCandidate& candidate) const;
  // The score of the candidate of these methods that is expected to err the least. None if there are no halves.
  std::optional<ScaleScore> FindReference(std::initializer_list<size_t> methods) const;
  // What is reference_of_positions_.
  std::optional<ScaleScore> FindReferenceOfPositions() const;
  // The score in this judge's quantity of a candidate with that score in the mean curvature, whose bias is as large
  // beside the difference.
  ScaleScore ScoreAs(const ScaleScore& of_mean) const;
  // The mean of the products of what each half of a neighborhood shows beyond that of another candidate, less what
  // chance makes of it: detail that one of them smooths away is common to both halves, noise is not. None without
  // halves.
  std::optional<double> SquaredBias(const ScaleCandidate& candidate, const ScaleCandidate& other) const;
  // The largest of them beside smaller neighborhoods.
  double SquaredBiasBesideSmaller(const ScaleCandidate& candidate) const;
  // That of a candidate beside a reference, of which this is the score: of methods of the second order, and in the
  // Gaussian curvature of all that look farther; 0 of others.
  double SquaredBiasBeside(const std::optional<ScaleScore>& reference, const ScaleCandidate& candidate) const;
  // That of a candidate that reads normals beside jets, of which this is the score, if the normals belong to another
  // surface than the positions; 0 of jets.
  double SquaredBiasOfNormals(const std::optional<ScaleScore>& jets, const ScaleCandidate& candidate) const;
  double NoiseBias(size_t method) const { return kScaleMethods[method].noise_factor * noise_bias_; }
  // REQUIRES: there is a difference of the candidate.
  ScaleScore ScoreOf(const ScaleCandidate& candidate) const;
  ScaleScore ScoreOf(const ScaleCandidate& candidate, double squared_bias) const;
  ScaleScore ScoreWithoutBias(const ScaleCandidate& candidate) const;
  // A difference tells the larger one of two errors. Where they rise from the first rung on, so that noise does not
  // matter, that of the first rung is the second one's, and its own is found as it would be at the other end.
  static void MendFirstRung(size_t first, std::vector<ScaleScore>& scores);

  const PilotPoints table_;
  const ScaleBounds bounds_;
  const Quantity quantity_;
  const CandidateValues values_;
  std::array<size_t, kRungCount> clear_counts_{};  // of points whose neighborhoods reach over no edge
  std::array<double, kRungCount> median_radii_, floors_;
  std::optional<double> differences_[kMethodCount][kRungCount];
  double variances_[kMethodCount][kRungCount] = {};
  size_t last_compared_[kMethodCount] = {};  // the last rung that has a next one
  double sigma_ = 0.0, noise_bias_ = 0.0;
  LostDetail lost_detail_;  // not where the quantity is the Gaussian curvature, which takes the biases of the mean one
  // The cubic regression of the normals that is expected to err the least: methods of the second order are compared
  // with it. Not where the quantity is the Gaussian curvature, which takes that of the mean curvature.
  std::optional<ScaleScore> reference_;
  // The jets that are expected to err the least, where positions are exact and the reference above shows another
  // surface: errors that normals share with their neighbors, as those made of positions do, neither halves nor scales
  // show.
  std::optional<ScaleScore> reference_of_positions_;
};

}  // namespace curvd
