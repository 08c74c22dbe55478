#include "core/scale/errors/error_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/quantile.h"
#include "core/scale/errors/scale_changes.h"
#include "core/scale/errors/student_factor.h"
#include "core/scale/local_weights.h"
#include "core/scale/nearest_samples.h"
#include "core/scale/pilot/pilot_sums.h"

namespace curvd {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// A bias that grows as its method's order says is taken to be so many times larger than it is: others grow less.
constexpr double kBiasMargin = 1.35;
// So many sampled points around one, and at least so many of them, tell together how large errors are beside changes:
// fewer than the squares are averaged over, since it depends on whether rounding or bias is what errs there.
constexpr size_t kNearest = 12, kLeastNearest = 6;
// Squares at single sampled points beyond this quantile are cut down to it.
constexpr double kSquareQuantile = 0.99;
// Rounding of normals to float32 moves curvature by up to this many times 1 / radius, four times its own 2^-24, in the
// smallest neighborhoods.
constexpr double kRounding = 0x1p-22;
// Slopes are taken so many rungs below the best scale of the regression that shows them, from a quarter of its
// neighbors: the estimate has lost some of the surface's own.
constexpr size_t kSlopeRungs = 4;
// Where the traceless part has weights of its own, they were chosen by what the halves show, which then is less than
// the noise: its variance is so many times that.
constexpr double kNoiseOfOwnWeights = 1.5;

// The roots of the shares that the one has of the other.
ShapeWeight RootShare(const ShapeWeight& one, const ShapeWeight& other) {
  return {std::sqrt(one.mean / other.mean), std::sqrt(one.traceless / other.traceless)};
}

double SquaredDistance(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  double sum = 0.0;
  for (size_t axis = 0; axis < 3; ++axis) sum += (double{a[axis]} - b[axis]) * (double{a[axis]} - b[axis]);
  return sum;
}

void AddProducts(const ShapeParts& a, const ShapeParts& b, double factor, ShapeParts& sum) {
  for (size_t part = 0; part < kShapeParts; ++part) sum[part] += factor * a[part] * b[part];
}

ScaleCandidate NextOf(const ScaleCandidate& one) {
  return {one.method, one.rung + kScaleMethods[one.method].compared_rungs};
}

// The change from a candidate's estimate to that of its next scale; NaN where there is none.
TangentShape ChangeOf(const PilotPoint& point, const ScaleCandidate& one, PilotPoint::Part part) {
  const ScaleCandidate next = NextOf(one);
  if (next.rung >= kRungCount) return {kNaN, kNaN, kNaN};
  return EstimateAt(point, one, part) - EstimateAt(point, next, part);
}

// Whether both halves have one.
bool HaveChanges(const PilotPoint& point, const ScaleCandidate& one) {
  return IsFinite(ChangeOf(point, one, PilotPoint::kEven)) && IsFinite(ChangeOf(point, one, PilotPoint::kOdd));
}

// The smoothing of a candidate in terms of a scale that has a next one: the largest that has one at half of the points
// and is no larger than the candidate.
struct Comparison {
  Comparison(PilotPoints table, const ScaleCandidate& candidate, const std::vector<ScaleScore>& scores)
      : from(candidate) {
    const auto is_known = [&](const PilotPoint& point) { return IsFinite(ChangeOf(point, from, PilotPoint::kAll)); };
    while (from.rung > 0 &&
           2 * static_cast<size_t>(std::count_if(table.begin(), table.end(), is_known)) < table.size()) {
      --from.rung;
    }
    // Smoothing takes away what grows at least with the square of the radius.
    factor = static_cast<double>(candidate.count()) / from.count();
    // That of a smooth surface, or what was found where changes grow less.
    bias_per_change = 1.0 / (BiasGrowth(from.method) - 1.0);
    for (const ScaleScore& score : scores) {
      if (score.candidate == from) bias_per_change = std::max(bias_per_change, score.bias_per_change);
    }
  }
  ScaleCandidate from;
  double factor;           // smoothing of the candidate over that of `from`
  double bias_per_change;  // of `from`, where its change has no noise in it
};

// Takes the samples of one sampled point after the other.
class ErrorSampler {
 public:
  ErrorSampler(PilotPoints table, const ScaleChoice& choice, std::span<const double> variance_factors)
      : table_(table),
        choice_(choice),
        variance_factors_(variance_factors),
        local_weights_(table, choice),
        samples_(table) {
    for (const ScaleCandidate& candidate : choice.chosen) comparisons_.emplace_back(table, candidate, choice.scores);
    const ScaleScore* best = nullptr;
    for (const ScaleScore& score : choice.scores) {
      if (score.candidate.method != kRegressionMethod) continue;
      if (best == nullptr || score.error < best->error) best = &score;
    }
    const size_t rung = best != nullptr ? best->candidate.rung : choice.chosen.front().rung;
    slope_rung_ = std::max(rung, kSlopeRungs) - kSlopeRungs;
  }

  ErrorSample At(size_t i) {
    const PilotPoint& point = table_[i];
    const Box at_point{point.position, point.position};
    local_weights_.Start(at_point);
    samples_.Start(at_point, kNearest);
    const LocalWeights::PointWeights weights = local_weights_.At(point.position.data());
    for (size_t c = 0; c < choice_.chosen.size(); ++c) weights_[c] = {weights.mean[c], weights.traceless[c]};
    ErrorSample sample;
    ShapeSum all;
    for (size_t c = 0; c < choice_.chosen.size(); ++c) {
      const TangentShape shape = EstimateAt(point, choice_.chosen[c], PilotPoint::kAll);
      if (!IsFinite(shape)) continue;
      all.Add(shape, weights_[c]);
      sample.floor += weights_[c].mean * kRounding / point.radius[choice_.chosen[c].rung];
    }
    if (!all.weight.IsPositive()) return sample;
    sample.floor /= all.weight.mean;
    const TangentShape shape = all.Mean();
    const PrincipalAxes axes(shape);
    SetNoise(point, axes, all.weight, sample);
    SetDetail(point, axes, sample);
    SetPlace(point, axes, sample);
    SetNoiseBias(shape, sample);
    return sample;
  }

 private:
  // Of the candidates that have estimates of both halves: the mean of two independent ones has a quarter of the
  // variance of their difference. What the others have of noise, their difference from the next scale holds. A bias
  // that no scale shows is taken to be as large as the noise (ScaleMethod::doubt).
  void SetNoise(const PilotPoint& point, const PrincipalAxes& axes, const ShapeWeight& all_weight,
                ErrorSample& sample) const {
    const double of_traceless = choice_.weights.traceless.trends.empty() ? 1.0 : kNoiseOfOwnWeights;
    ShapeSum even, odd;
    ShapeWeight factor;
    for (size_t c = 0; c < choice_.chosen.size(); ++c) {
      const TangentShape one = EstimateAt(point, choice_.chosen[c], PilotPoint::kEven);
      const TangentShape other = EstimateAt(point, choice_.chosen[c], PilotPoint::kOdd);
      if (!IsFinite(one) || !IsFinite(other)) continue;
      even.Add(one, weights_[c]);
      odd.Add(other, weights_[c]);
      const double of_one = variance_factors_[c] * kScaleMethods[choice_.chosen[c].method].doubt;
      factor += {of_one * weights_[c].mean, of_traceless * of_one * weights_[c].traceless};
    }
    if (!even.weight.IsPositive()) return;
    const TangentShape difference = RootShare(factor, even.weight) * (even.Mean() - odd.Mean());
    const ShapeWeight share = {even.weight.mean / all_weight.mean, even.weight.traceless / all_weight.traceless};
    const ShapeParts parts = axes.PartsOf(share * difference);
    AddProducts(parts, parts, 0.25, sample.noise);
  }

  // The product of what the halves lose has no noise in it. Without halves the whole change tells noise and detail
  // together: there the errors of candidates are taken to have the same sign, as nobody knows which cancel out.
  void SetDetail(const PilotPoint& point, const PrincipalAxes& axes, ErrorSample& sample) {
    ShapeWeight weight, whole_weight;
    for (size_t c = 0; c < choice_.chosen.size(); ++c) {
      if (!IsFinite(ChangeOf(point, comparisons_[c].from, PilotPoint::kAll))) continue;
      weight += weights_[c];
      if (!HaveChanges(point, comparisons_[c].from)) whole_weight += weights_[c];
    }
    if (!weight.IsPositive()) return;
    ShapeParts of_whole{};
    for (size_t c = 0; c < choice_.chosen.size(); ++c) {
      const auto& [from, factor, bias_per_change] = comparisons_[c];
      const TangentShape whole = ChangeOf(point, from, PilotPoint::kAll);
      if (!IsFinite(whole)) continue;
      const double share = weights_[c].mean / weight.mean;
      if (HaveChanges(point, from)) {
        const double bias = factor * bias_per_change, error = kBiasMargin * bias;
        const ShapeWeight root = RootShare(weights_[c], weight);
        AddProducts(axes.PartsOf(root * ChangeOf(point, from, PilotPoint::kEven)),
                    axes.PartsOf(root * ChangeOf(point, from, PilotPoint::kOdd)), error * error, sample.detail);
        sample.lean -= share * bias * whole.mean;
        continue;
      }
      const double error = factor * ErrorPerChange(point, from);
      const ShapeWeight among_whole = RootShare(weights_[c], whole_weight), among_all = RootShare(weights_[c], weight);
      const ShapeParts parts = axes.PartsOf(
          ShapeWeight{among_whole.mean * among_all.mean, among_whole.traceless * among_all.traceless} * whole);
      for (size_t part = 0; part < kShapeParts; ++part) of_whole[part] += error * std::abs(parts[part]);
      sample.lean -= share * error * whole.mean;
    }
    AddProducts(of_whole, of_whole, 1.0, sample.detail);
    sample.is_known = true;
  }

  // How many times larger than its change to the next scale a candidate's error is around the point of the moment.
  double ErrorPerChange(const PilotPoint& point, const ScaleCandidate& candidate) {
    ScaleChanges changes(candidate.method);
    size_t known = 0;
    double squared_reach = 0.0;
    for (const uint32_t i : samples_.At(point.position.data())) {
      const TangentShape first = ChangeOf(table_[i], candidate, PilotPoint::kAll);
      const TangentShape second = ChangeOf(table_[i], NextOf(candidate), PilotPoint::kAll);
      if (!IsFinite(first) || !IsFinite(second)) continue;
      changes.Add(first.mean, second.mean);
      changes.Add(first.difference, second.difference);
      changes.Add(first.twist, second.twist);
      squared_reach = std::max(squared_reach, SquaredDistance(table_[i].position, point.position));
      ++known;
    }
    if (known < kLeastNearest) return kBiasMargin;
    return StudentFactor(IndependentOf(known, squared_reach, point, candidate)) * changes.ErrorPerChange();
  }

  // How many of the samples within that reach are independent: neighborhoods that overlap have errors in common, as all
  // of them do in small clouds. Those of jets do as well, but their changes are mostly larger than their errors.
  static double IndependentOf(size_t known, double squared_reach, const PilotPoint& point,
                              const ScaleCandidate& candidate) {
    const double count = static_cast<double>(known);
    if (kScaleMethods[candidate.method].is_jet()) return count;
    const double radius = point.radius[candidate.rung];
    return std::min(1.0 + squared_reach / (radius * radius), count);
  }

  // The noise of the halves' slopes is independent: what is left of their product is the surface's own.
  void SetPlace(const PilotPoint& point, const PrincipalAxes& axes, ErrorSample& sample) const {
    const std::optional<size_t> rung = SlopeRung(point);
    if (!rung.has_value()) return;
    for (size_t axis = 0; axis < 2; ++axis) {
      const auto along = [&](PilotPoint::Part part) {
        const auto& slopes = point.slope[*rung][part];
        return axes.PartsOf({slopes[3 * axis], slopes[3 * axis + 1], slopes[3 * axis + 2]});
      };
      AddProducts(along(PilotPoint::kEven), along(PilotPoint::kOdd), choice_.sigma * choice_.sigma, sample.place);
    }
  }

  // slope_rung_, or the nearest one that has slopes of both halves, or a smaller one.
  std::optional<size_t> SlopeRung(const PilotPoint& point) const {
    const auto is_known = [&](size_t rung) {
      const auto& slopes = point.slope[rung];
      return std::isfinite(slopes[PilotPoint::kEven][0]) && std::isfinite(slopes[PilotPoint::kOdd][0]);
    };
    for (size_t rung = slope_rung_; rung < kRungCount; ++rung) {
      if (is_known(rung)) return rung;
    }
    for (size_t rung = slope_rung_; rung-- > 0;) {
      if (is_known(rung)) return rung;
    }
    return std::nullopt;
  }

  // Noise in the positions moves the neighbors along the surface as well (ScaleMethod::noise_factor).
  void SetNoiseBias(const TangentShape& shape, ErrorSample& sample) const {
    const double half = std::hypot(shape.difference, shape.twist), steepest = std::abs(shape.mean) + half;
    ShapeWeight sum, weight;
    for (size_t c = 0; c < choice_.chosen.size(); ++c) {
      const double relative_bias =
          kScaleMethods[choice_.chosen[c].method].noise_factor * choice_.sigma * choice_.sigma * steepest * steepest;
      const double square = relative_bias * relative_bias;
      sum += {weights_[c].mean * square, weights_[c].traceless * square};
      weight += weights_[c];
    }
    sample.noise_bias = shape.mean * shape.mean * sum.mean / weight.mean;
    sample.half_noise_bias = half * half * sum.traceless / weight.traceless;
  }

  const PilotPoints table_;
  const ScaleChoice& choice_;
  const std::span<const double> variance_factors_;
  std::vector<Comparison> comparisons_;  // of each chosen candidate
  size_t slope_rung_ = 0;                // that slopes are wanted of
  LocalWeights local_weights_;
  std::array<ShapeWeight, ScaleChoice::kMostChosen> weights_{};  // at the point of the moment
  NearestSamples samples_;
};

// Cuts outliers of one part over all samples. REQUIRES: there is a known one.
void CutOutliers(ShapeParts ErrorSample::*member, size_t part, std::vector<ErrorSample>& samples) {
  std::vector<double> values;
  for (const ErrorSample& sample : samples) {
    if (sample.is_known) values.push_back((sample.*member)[part]);
  }
  const double most = LowerQuantile(values, kSquareQuantile);
  const double least = std::min(LowerQuantile(values, 1.0 - kSquareQuantile), 0.0);
  for (ErrorSample& sample : samples) (sample.*member)[part] = std::clamp((sample.*member)[part], least, most);
}

}  // namespace

std::vector<ErrorSample> SampleErrors(PilotPoints table, const ScaleChoice& choice,
                                      std::span<const double> variance_factors) {
  ErrorSampler sampler(table, choice, variance_factors);
  std::vector<ErrorSample> samples;
  samples.reserve(table.size());
  for (size_t i = 0; i < table.size(); ++i) samples.push_back(sampler.At(i));
  if (std::none_of(samples.begin(), samples.end(), [](const ErrorSample& sample) { return sample.is_known; })) {
    return samples;
  }
  for (size_t part = 0; part < kShapeParts; ++part) {
    for (const auto member : {&ErrorSample::noise, &ErrorSample::detail, &ErrorSample::place}) {
      CutOutliers(member, part, samples);
    }
  }
  return samples;
}

}  // namespace curvd
