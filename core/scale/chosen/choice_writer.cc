#include "core/scale/chosen/choice_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include "core/scale/automatic_options.h"
#include "core/scale/chosen/chosen_estimates.h"
#include "core/scale/errors/attenuation.h"
#include "core/scale/errors/error_samples.h"

namespace curvd {
namespace {

// Standard errors are those of all chosen estimates: a point that has lost more of their weights has none.
constexpr double kLeastShareWithErrors = 0.9;

// Where the averaged estimates differ from each other by so many standard errors, something is near the point that the
// samples around it do not have, such as the border of a noisy part, or an outlier. Their spread tells the error then.
constexpr double kMostSpread = 4.0;

float WithSpread(float error, double spread) {
  return spread > kMostSpread * error ? static_cast<float>(spread) : error;
}

}  // namespace

ChoiceWriter::ChoiceWriter(const EstimatorOptions& options, const SpatialIndex& index, const CloudChoice& choice,
                           const PointCurvature* results, PointChoice* choices)
    : options_(options), index_(index), choice_(choice), results_(results), choices_(choices) {
  for (const PartChoice& part : choice.parts()) {
    std::vector<double> variance_factors;
    for (const ScaleCandidate& candidate : part.choice.chosen) {
      variance_factors.push_back(VarianceFactor(options, candidate));
    }
    errors_.push_back(part.choice.scores.empty() ? ErrorModel()
                                                 : ErrorModel(SampleErrors(part.samples, part.choice, variance_factors),
                                                              FindAttenuation(part.samples, part.choice)));
  }
}

void ChoiceWriter::Start(AutomaticScratch& s) const {
  if (s.samples.empty()) {
    for (const PartChoice& part : choice_.parts()) s.samples.emplace_back(part.samples);
  }
  for (NearestSamples& of_part : s.samples) of_part.Start(s.points.box, ErrorModel::kNearest);
}

void ChoiceWriter::WriteMended(size_t point, AutomaticScratch& s) const {
  const CloudWeights::Weights& all = s.WeightsAt(point).mean;
  const double total = std::accumulate(all.begin(), all.end(), 0.0);
  Write(point, s.blends[point].weight() >= kLeastShareWithErrors * total, s);
}

size_t ChoiceWriter::bytes() const {
  size_t bytes = errors_.capacity() * sizeof(ErrorModel);
  for (const ErrorModel& of_part : errors_) bytes += of_part.bytes();
  return bytes;
}

void ChoiceWriter::Write(size_t point, bool has_errors, AutomaticScratch& s) const {
  const PointCurvature& result = results_[s.points.slot[point]];
  PointChoice& choice = choices_[s.points.slot[point]];
  choice = UndefinedChoice();
  if (result.status != PointStatus::kOk) return;
  if (const std::optional<PointFit>& fit = s.own_fits[point]) {
    choice.neighbor_count = static_cast<float>(fit->neighbor_count);
    choice.jet_weight = fit->is_by_heights ? 1.0f : 0.0f;
    choice.normal_regression_weight = 1.0f - choice.jet_weight;
    choice.avg_hexagram_weight = choice.aso_weight = 0.0f;
    // Its residuals do not show the errors that neighbors share where there are half normals.
    if (!fit->is_by_heights && index_.has_half_normals()) return;
    choice.mean_error = static_cast<float>(fit->mean_error);
    choice.k1_error = static_cast<float>(fit->k1_error);
    choice.k2_error = static_cast<float>(fit->k2_error);
    return;
  }
  // What all reach over an edge was sampled where they do not.
  if (ChosenEstimates::IsOneSided(s, point)) return;
  const size_t part = s.part[point];
  const Blend& blend = s.ClearBlend(point);
  CloudWeights::Weights shares = s.shares[point];
  if (blend.IsContradictory()) KeepSteady(shares);
  SetWeights(shares, choice);
  if (!has_errors) return;
  float position[3];
  s.points.query.Get(point, position);
  const auto of_index = [this](double curvature) { return std::ldexp(curvature, -index_.scale_exponent()); };
  const StandardErrors errors = errors_[part].At(s.samples[part].At(position), of_index(result.mean),
                                                 of_index(0.5 * (double{result.k2} - result.k1)));
  const Blend::Spread spread = blend.spread();
  choice.mean_error = WithSpread(ToCaller(errors.mean), std::max(spread.mean, s.doubts[point]));
  choice.k1_error = WithSpread(ToCaller(errors.k1), std::max(spread.k1, s.doubts[point]));
  choice.k2_error = WithSpread(ToCaller(errors.k2), std::max(spread.k2, s.doubts[point]));
}

// Of those that may be steady and count at a point, the one of fewest neighbors alone holds there.
void ChoiceWriter::KeepSteady(CloudWeights::Weights& shares) const {
  std::optional<size_t> steady;
  for (size_t c = 0; c < choice_.chosen().size(); ++c) {
    if (!(shares[c] > 0.0) || !choice_.MayBeSteady(c)) continue;
    if (!steady.has_value() || choice_.chosen()[c].rung < choice_.chosen()[*steady].rung) steady = c;
  }
  shares = {};
  shares[*steady] = 1.0;
}

float ChoiceWriter::ToCaller(double curvature) const {
  return static_cast<float>(std::ldexp(curvature, index_.scale_exponent()));
}

// `shares` are the weights of the estimates that the point has.
void ChoiceWriter::SetWeights(const CloudWeights::Weights& shares, PointChoice& choice) const {
  const double total = std::accumulate(shares.begin(), shares.end(), 0.0);
  std::array<double, kMethodCount> of_method{};
  double count = 0.0;
  for (size_t c = 0; c < choice_.chosen().size(); ++c) {
    const ScaleCandidate& candidate = choice_.chosen()[c];
    of_method[candidate.method] += shares[c] / total;
    count += shares[c] / total * FixedCount(options_).value_or(candidate.count());
  }
  choice.neighbor_count = static_cast<float>(count);
  choice.avg_hexagram_weight = static_cast<float>(of_method[kHexagramMethod]);
  choice.normal_regression_weight = static_cast<float>(
      of_method[kRegressionMethod] + of_method[kQuadraticRegressionMethod] + of_method[kLinearRegressionMethod]);
  choice.jet_weight =
      static_cast<float>(of_method[kQuarticMethod] + of_method[kQuadricMethod] + of_method[kSexticMethod]);
  choice.aso_weight = static_cast<float>(of_method[kSphereMethod]);
}

}  // namespace curvd
