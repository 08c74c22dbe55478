// Judges by a table of estimates how far each way to estimate a cloud is off (docs/numerics/automatic_choice.md).
#pragma once

#include <array>
#include <initializer_list>
#include <optional>
#include <vector>

#include "core/estimators/scale_ladder.h"
#include "core/scale/judging/candidate_differences.h"
#include "core/scale/judging/growing_bias.h"
#include "core/scale/judging/lost_detail.h"
#include "core/scale/pilot/pilot_table.h"
#include "core/scale/scale_choice.h"

namespace curvd {

// Of one quantity. Const methods are thread-safe. Lengths are in the index's unit.
class ScaleJudge {
 public:
  using Quantity = CandidateDifferences::Quantity;

  // `table` and `lost_detail` outlive the object.
  ScaleJudge(PilotPoints table, const ScaleBounds& bounds, const LostDetail& lost_detail, Quantity quantity);

  // Of all candidates that can be judged and are within the bounds, by method, then by rung. Not of the Gaussian
  // curvature.
  std::vector<ScaleScore> Scores() const;
  // The scores of candidates that another judge has judged by the mean curvature. Their biases are as large beside the
  // differences as there, at the least: noise in a small neighborhood moves the Gaussian curvature of both halves to
  // one side, as detail would.
  std::vector<ScaleScore> ScoresOf(const std::vector<ScaleScore>& of_mean, const ScaleJudge& judge_of_mean) const;

  // What the scores are made of.
  const CandidateDifferences& differences() const { return differences_; }
  // Noise of the positions; 0 if nothing tells it.
  double sigma() const { return sigma_; }

 private:
  bool IsAllowed(const ScaleCandidate& candidate) const;
  // What noise in the positions does to an estimate of noise factor 1.
  double FindNoiseBias() const;
  double NoiseBias(size_t method) const { return kScaleMethods[method].noise_factor * noise_bias_; }
  // The score of the candidate of these methods that is expected to err the least. None if there are no halves.
  std::optional<ScaleScore> FindReference(std::initializer_list<size_t> methods) const;
  // What is reference_of_positions_.
  std::optional<ScaleScore> FindReferenceOfPositions() const;
  // The squared bias of a candidate beside a reference, of which this is the score: of methods of the second order, and
  // in the Gaussian curvature of all that look farther; 0 of others.
  double SquaredBiasBeside(const std::optional<ScaleScore>& reference, const ScaleCandidate& candidate) const;
  // That of a candidate that reads normals beside jets, of which this is the score, if the normals belong to another
  // surface than the positions; 0 of jets.
  double SquaredBiasOfNormals(const std::optional<ScaleScore>& jets, const ScaleCandidate& candidate) const;
  // What changes between scales, and waves that are lost, tell of the candidate's squared bias.
  double SquaredBiasOfChanges(const ScaleCandidate& candidate) const;
  // Methods of which the first variance that halves tell is that of noise.
  MethodSet FindNoisyMethods() const;
  // The score in this judge's quantity of a candidate with that score in the mean curvature, whose bias is as large
  // beside the difference.
  ScaleScore ScoreAs(const ScaleScore& of_mean, const MethodSet& noisy) const;
  // REQUIRES: there is a difference of the candidate.
  ScaleScore ScoreOf(const ScaleCandidate& candidate) const;
  ScaleScore ScoreOf(const ScaleCandidate& candidate, double squared_bias, const MethodSet& noisy) const;
  ScaleScore ScoreWithoutBias(const ScaleCandidate& candidate, const MethodSet& noisy) const;
  // A difference tells the larger one of two errors. Where they rise from the first rung on, so that noise does not
  // matter, that of the first rung is the second one's, and its own is found as it would be at the other end.
  static void MendFirstRung(size_t first, std::vector<ScaleScore>& scores);

  const ScaleBounds bounds_;
  const CandidateDifferences differences_;
  const LostDetail& lost_detail_;
  std::array<GrowingBias, kMethodCount> growing_bias_;
  MethodSet noisy_{};  // not where the quantity is the Gaussian curvature, which takes those of the mean curvature
  const double sigma_, noise_bias_;
  // The cubic regression of the normals that is expected to err the least: methods of the second order are compared
  // with it. Not where the quantity is the Gaussian curvature, which takes that of the mean curvature.
  std::optional<ScaleScore> reference_;
  // The jets that are expected to err the least, where positions are exact and the reference above shows another
  // surface: errors that normals share with their neighbors, as those made of positions do, neither halves nor scales
  // show.
  std::optional<ScaleScore> reference_of_positions_;
};

}  // namespace curvd
