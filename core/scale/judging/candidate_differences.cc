#include "core/scale/judging/candidate_differences.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/base/median.h"
#include "core/base/quantile.h"
#include "core/scale/errors/scale_changes.h"
#include "core/scale/pilot/sample_medians.h"

namespace curvd {
namespace {

// Of the sampled points, so many must have an estimate, or a difference of halves, for a candidate to be judged.
constexpr double kLeastShare = 0.97, kLeastShareOfHalves = 0.95;
// At the least, unless the table has fewer.
constexpr size_t kLeastPoints = 16;
// The difference from the next larger scale is so much smaller than the error.
constexpr double kErrorPerDifference = 1.2;
// Products of differences beyond these quantiles are cut down to them: edges of the surface are few.
constexpr double kProductQuantile = 0.95;
// A quarter of the squared median difference of halves, times this, is the variance of their mean, if it is Gaussian.
constexpr double kVariancePerSquaredMedian = 2.2;
// The same of vectors of two components: the squared median length of them is 2 ln 2 times the variance of one.
constexpr double kVariancePerSquaredMedianOfVectors = 1.44;
// The mean of those products tells a bias if it is at least this share of their root mean square. It is looked for at a
// dozen smaller rungs, and noise of the smallest, which is thousands of times the bias of larger ones, comes to twice
// its standard error by chance.
constexpr double kLeastCommon = 0.25;
// Differences at single points beyond this quantile are cut down to it.
constexpr double kDifferenceQuantile = 0.99;
// Rounding of normals to float32 moves the curvature of the first rung by up to this many times 1 / radius: no
// difference says less. That of more normals averages out, as noise does.
constexpr double kRounding = 1e-6;

// The mean of values of which those beyond the quantile are cut down to it.
double CutMean(const std::vector<double>& values) {
  const double most = LowerQuantile(values, kDifferenceQuantile);
  double sum = 0.0;
  for (const double value : values) sum += std::min(value, most);
  return sum / static_cast<double>(values.size());
}

// How far the values of two candidates, or of one in two parts, lie apart, where they do.
std::vector<double> DistancesOf(const CandidateValues::Column& one, const CandidateValues::Column& other) {
  std::vector<double> distances;
  distances.reserve(one.size());
  for (size_t i = 0; i < one.size(); ++i) {
    if (const double distance = one.DistanceAt(i, other); std::isfinite(distance)) distances.push_back(distance);
  }
  return distances;
}

}  // namespace

CandidateDifferences::CandidateDifferences(PilotPoints table, Quantity quantity)
    : table_(table), quantity_(quantity), values_(table, quantity) {
  for (const PilotPoint& point : table_) {
    for (size_t rung = 0; rung < point.clear_rungs; ++rung) ++clear_counts_[rung];
  }
  for (size_t rung = 0; rung < kRungCount; ++rung) {
    median_radii_[rung] = curvd::MedianRadius(table_, rung);
    floors_[rung] = FloorAt(rung);
  }
  for (size_t m = 0; m < kMethodCount; ++m) {
    const size_t step = kScaleMethods[m].compared_rungs;
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      of_cloud_[m][rung] = MedianDifference({m, rung}, step);
      variances_[m][rung] = VarianceOf({m, rung});
    }
    AddLastDifferences(m);
  }
}

std::vector<double> CandidateDifferences::AtPoints(const ScaleCandidate& candidate, PilotPoint::Part part) const {
  const size_t step = kScaleMethods[candidate.method].compared_rungs;
  const size_t rung = ComparedRung(candidate);
  std::vector<double> errors(table_.size(), std::numeric_limits<double>::quiet_NaN()), known;
  if (rung + step < kRungCount) {
    const CandidateValues::Column one = values_.Of({candidate.method, rung}, part);
    const CandidateValues::Column next = values_.Of({candidate.method, rung + step}, part);
    for (size_t i = 0; i < table_.size(); ++i) {
      errors[i] = one.DistanceAt(i, next);
      if (std::isfinite(errors[i])) known.push_back(errors[i]);
    }
  }
  if (known.empty()) return std::vector<double>(table_.size(), 1.0);
  const double most = LowerQuantile(known, kDifferenceQuantile);
  const double usual = std::min(kErrorPerDifference * Median(std::move(known)), most);
  for (size_t i = 0; i < table_.size(); ++i) {
    const bool is_clear = table_[i].clear_rungs > rung + step;
    errors[i] = std::isfinite(errors[i]) ? std::min(errors[i], most) : is_clear ? most : usual;
  }
  return errors;
}

bool CandidateDifferences::HasHalves(const ScaleCandidate& candidate) const {
  const CandidateValues::Column even = values_.Of(candidate, PilotPoint::kEven),
                                odd = values_.Of(candidate, PilotPoint::kOdd);
  size_t known = 0;
  for (size_t i = 0; i < table_.size(); ++i) known += std::isfinite(even.DistanceAt(i, odd)) ? 1 : 0;
  return IsEnough(known, kLeastShareOfHalves, candidate.rung);
}

size_t CandidateDifferences::FirstWithVariance(size_t method) const {
  const auto& variances = variances_[method];
  return static_cast<size_t>(
      std::find_if(std::begin(variances), std::end(variances), [](double v) { return v > 0.0; }) -
      std::begin(variances));
}

double CandidateDifferences::VarianceBeforeFirst(const ScaleCandidate& candidate) const {
  const auto& variances = variances_[candidate.method];
  const size_t step = kScaleMethods[candidate.method].compared_rungs, first = FirstWithVariance(candidate.method);
  if (candidate.rung >= first || first + step >= kRungCount || variances[first + step] == 0.0) return 0.0;
  const double of_noise = 1.0 / VarianceLeft(candidate.method), found = variances[first] / variances[first + step];
  if (found < std::sqrt(of_noise)) return 0.0;
  const double steps = static_cast<double>(first - candidate.rung) / static_cast<double>(step);
  return variances[first] * std::pow(std::min(found, of_noise), steps);
}

std::optional<CommonChange> CandidateDifferences::CommonTo(const ScaleCandidate& candidate,
                                                           const ScaleCandidate& other) const {
  std::vector<double> products;
  const CandidateValues::Column even = values_.Of(candidate, PilotPoint::kEven),
                                other_even = values_.Of(other, PilotPoint::kEven);
  const CandidateValues::Column odd = values_.Of(candidate, PilotPoint::kOdd),
                                other_odd = values_.Of(other, PilotPoint::kOdd);
  for (size_t i = 0; i < table_.size(); ++i) {
    double product = (even.first[i] - other_even.first[i]) * (odd.first[i] - other_odd.first[i]);
    if (!even.second.empty()) {
      product += (even.second[i] - other_even.second[i]) * (odd.second[i] - other_odd.second[i]);
    }
    if (std::isfinite(product)) products.push_back(product);
  }
  if (!IsEnough(products.size(), kLeastShareOfHalves, std::max(candidate.rung, other.rung))) return std::nullopt;
  const double low = LowerQuantile(products, 1.0 - kProductQuantile), high = LowerQuantile(products, kProductQuantile);
  double sum = 0.0, squares = 0.0;
  for (const double product : products) {
    const double clipped = std::clamp(product, low, high);
    sum += clipped;
    squares += clipped * clipped;
  }
  const double size = static_cast<double>(products.size()), mean = sum / size;
  // Neighborhoods of sampled points overlap: a quarter of the points are independent.
  const double standard_error = std::sqrt(std::max(squares / size - mean * mean, 0.0) / (size / 4.0));
  return CommonChange{mean, standard_error, squares / size};
}

std::optional<double> CandidateDifferences::CommonSquare(const ScaleCandidate& candidate,
                                                         const ScaleCandidate& other) const {
  const std::optional<CommonChange> common = CommonTo(candidate, other);
  if (!common.has_value()) return std::nullopt;
  const bool counts = common->mean > kLeastCommon * std::sqrt(common->mean_square);
  return counts ? common->mean - 2.0 * common->standard_error : 0.0;
}

double CandidateDifferences::CommonSquareBesideSmaller(const ScaleCandidate& candidate) const {
  double most = 0.0;
  for (size_t rung = candidate.rung; rung-- > 0;) {
    const std::optional<double> common = CommonSquare(candidate, {candidate.method, rung});
    if (!common.has_value()) break;
    most = std::max(most, *common);
  }
  return most;
}

GrowingBias CandidateDifferences::FindGrowingBias(size_t method) const {
  const size_t step = kScaleMethods[method].compared_rungs;
  std::array<std::optional<CommonChange>, kRungCount> changes;
  for (size_t rung = 0; rung + step < kRungCount; ++rung) {
    changes[rung] = CommonTo({method, rung}, {method, rung + step});
  }
  return {changes, step};
}

size_t CandidateDifferences::ComparedRung(const ScaleCandidate& candidate) const {
  return std::min(candidate.rung, last_compared_[candidate.method]);
}

bool CandidateDifferences::IsEnough(size_t count, double share, size_t rung) const {
  return count >= std::min(table_.size(), kLeastPoints) &&
         static_cast<double>(count) >= share * static_cast<double>(clear_counts_[rung]);
}

bool CandidateDifferences::HasEstimates(const ScaleCandidate& candidate) const {
  const CandidateValues::Column values = values_.Of(candidate);
  const auto known =
      std::count_if(values.first.begin(), values.first.end(), [](double value) { return std::isfinite(value); });
  return IsEnough(static_cast<size_t>(known), kLeastShare, candidate.rung);
}

double CandidateDifferences::FloorAt(size_t rung) const {
  const double averaged = std::sqrt(static_cast<double>(kScaleRungs.front()) / kScaleRungs[rung]);
  const double of_mean = kRounding * averaged / median_radii_[rung];
  if (quantity_ != Quantity::kGaussian) return of_mean;
  const double steepest = MedianOf(table_, [rung](const PilotPoint& point) { return point.steepest[rung]; });
  return of_mean * std::max(2.0 * (std::isfinite(steepest) ? steepest : 0.0), of_mean);
}

double CandidateDifferences::VarianceOf(const ScaleCandidate& candidate) const {
  std::vector<double> values =
      DistancesOf(values_.Of(candidate, PilotPoint::kEven), values_.Of(candidate, PilotPoint::kOdd));
  if (!IsEnough(values.size(), kLeastShareOfHalves, candidate.rung)) return 0.0;
  const double median = Median(std::move(values));
  const double factor =
      quantity_ == Quantity::kTraceless ? kVariancePerSquaredMedianOfVectors : kVariancePerSquaredMedian;
  return 0.25 * factor * median * median;
}

std::optional<double> CandidateDifferences::MedianDifference(const ScaleCandidate& candidate, size_t step) const {
  const size_t next = candidate.rung + step;
  if (next >= kRungCount) return std::nullopt;
  const std::vector<double> values = DistancesOf(values_.Of(candidate), values_.Of({candidate.method, next}));
  if (!IsEnough(values.size(), kLeastShare, next)) return std::nullopt;
  return std::max(CutMean(values), kErrorPerDifference * Median(values));
}

void CandidateDifferences::AddLastDifferences(size_t method) {
  auto& differences = of_cloud_[method];
  size_t rung = kRungCount;
  while (rung > 0 && !differences[rung - 1].has_value()) --rung;
  last_compared_[method] = rung > 0 ? rung - 1 : 0;
  if (rung < 2) return;
  for (double ratio = 1.0; rung < kRungCount && HasEstimates({method, rung}); ++rung) {
    const auto step = MedianDifference({method, rung}, 1), before = MedianDifference({method, rung - 1}, 1);
    if (step.has_value() && before.has_value() && *before > 0.0) {
      ratio = *step / *before;
    } else if (const auto first = MedianDifference({method, rung - 2}, 1);
               before.has_value() && first.value_or(0.0) > 0.0) {
      ratio = *before / *first;
    }
    differences[rung] = *differences[rung - 1] * ratio;
  }
}

}  // namespace curvd
