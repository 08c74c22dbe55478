#include "core/scale/point_fits/height_fit.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>

#include "core/estimators/scale_ladder.h"
#include "core/scale/point_fits/field_curvature.h"

namespace curvd {
namespace {

using Eigen::Matrix3d;
constexpr size_t kMostDegree = 4;
using Heights = PolynomialEquations<kMostDegree, 1>;

// Where x^2, x y and y^2 are among the monomials.
constexpr int kXX = 3, kXY = 4, kYY = 5;

// Neighbors beyond as many as there are coefficients. Fewer say too little of what a fit leaves.
constexpr double kLeastFreedomOfHeights = 8.0;
constexpr double kCautionByFreedom = 4.0;
// The variance of H by one neighbor's, times their number, in units of the radius: over an even disc it is 48 of degree
// 2 and 768 of degree 4, at a border 255 and 83,000, in a right-angled corner 612 and 450,000. What has far more is
// told by rounding alone, as of neighbors on one line, which any polynomial across it fits.
template <int kDegree>
constexpr double kMostSpread = kDegree == 2 ? 5e3 : 1e6;

// Where neighbors lie across a line is told in bins, of which so many make the radius. So many empty ones part lines,
// and are so many times as wide as a line.
constexpr int kBinsOfRadius = 31, kLeastGapInBins = 6, kLeastGapOverWidth = 4;
using Bins = std::bitset<2 * kBinsOfRadius + 1>;
// The line through a point goes through one of its nearest neighbors.
constexpr size_t kNearestOnLine = 3;

// How many lines there are in the bins that hold neighbors; nothing if what lies between gaps is too wide for lines.
std::optional<size_t> LinesIn(const Bins& bins) {
  size_t lines = 0;
  int first = 0, last = -kLeastGapInBins - 1, widest = 0, least_gap = kBinsOfRadius;
  for (int bin = 0; bin < static_cast<int>(bins.size()); ++bin) {
    if (!bins[static_cast<size_t>(bin)]) continue;
    const int gap = bin - last - 1;
    if (gap >= kLeastGapInBins) {
      if (lines++ > 0) least_gap = std::min(least_gap, gap);
      first = bin;
    }
    last = bin;
    widest = std::max(widest, last - first);
  }
  return kLeastGapOverWidth * widest > least_gap ? std::nullopt : std::optional(lines);
}

// On how many lines of a scanner the neighbors lie, all of one direction; their own number if they do not.
size_t LinesOf(const NormalFrame& frame, std::span<const NeighborNormal* const> neighbors) {
  size_t fewest = neighbors.size(), tried = 0;
  const double radius = neighbors.back()->offset.norm();
  for (size_t k = 0; k < neighbors.size() && tried < kNearestOnLine; ++k) {
    const double x = frame.u.dot(neighbors[k]->offset), y = frame.v.dot(neighbors[k]->offset);
    const double length = std::hypot(x, y);
    if (!(length > 0.0)) continue;
    ++tried;
    const Eigen::Vector3d across = (y * frame.u - x * frame.v) / length * (kBinsOfRadius / radius);
    Bins bins;
    for (const NeighborNormal* const neighbor : neighbors) {
      bins.set(static_cast<size_t>(kBinsOfRadius + std::lround(across.dot(neighbor->offset))));
    }
    fewest = std::min(fewest, LinesIn(bins).value_or(fewest));
  }
  return fewest;
}

// What is known of the neighbors of a fit. Lengths are in units of `unit`.
struct HeightsAround {
  const Heights& equations;
  size_t count;
  double unit;
  double noise;  // of the positions
};

// Half the width of the interval around an estimate that holds the truth nine times in ten, over its error.
constexpr double kHalfWidthOfHeights = 1.645;

// The fit of so many neighbors.
template <int kDegree>
std::optional<PointFit> FitHeights(const NormalFrame& frame, const HeightsAround& around, double radius) {
  const auto& [equations, count, unit, noise] = around;
  const double freedom = static_cast<double>(count) - kPolynomialTerms[kDegree];
  if (freedom < kLeastFreedomOfHeights) return std::nullopt;
  const auto fit = equations.SolveDegree<kDegree>();
  if (!fit.has_value()) return std::nullopt;
  const auto of_xx = fit->Weights(kXX), of_yy = fit->Weights(kYY);
  const double spread = of_xx[kXX] + of_yy[kYY] + 2.0 * of_xx[kYY];
  const double per_unit = radius / unit, fourth = per_unit * per_unit * per_unit * per_unit;
  if (!(spread * static_cast<double>(count) * fourth <= kMostSpread<kDegree>)) return std::nullopt;
  const double variance = std::max(fit->squares / freedom, noise * noise / (unit * unit));
  const double error = std::sqrt(variance * spread * static_cast<double>(count)) / unit;
  const auto c = [&](int term) { return fit->coefficients(term, 0); };
  Matrix3d field;  // of normals, which are not of unit length
  field.row(0) = frame.n - c(1) * frame.u - c(2) * frame.v;
  field.row(1) = -2.0 * c(kXX) * frame.u - c(kXY) * frame.v;
  field.row(2) = -c(kXY) * frame.u - 2.0 * c(kYY) * frame.v;
  const auto point = CurvatureOfField(frame, field, unit, radius);
  if (!point.has_value()) return std::nullopt;
  const double cautious = error * (1.0 + kCautionByFreedom / freedom);
  const double of_principal = std::sqrt(2.0) * cautious;
  return PointFit{*point, count, cautious, of_principal, of_principal, true};
}

}  // namespace

std::optional<PointFit> EstimateByHeights(const NormalFrame& frame, std::span<const NeighborNormal* const> neighbors,
                                          uint32_t least_count, double noise) {
  const double radius = neighbors.empty() ? 0.0 : neighbors.back()->offset.norm();
  if (!(radius > 0.0)) return std::nullopt;
  Heights equations;
  std::optional<PointFit> best;
  size_t added = 0, lines = 0;
  // What the intervals of degree 4 so far have in common. Fits of more neighbors that miss it have smoothed detail
  // away.
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  for (const uint32_t count : kScaleRungs) {
    if (count < least_count) continue;
    if (count > neighbors.size()) break;
    for (; added < count; ++added) {
      const Eigen::Vector3d offset = neighbors[added]->offset / radius;
      equations.Add(frame.u.dot(offset), frame.v.dot(offset), Eigen::Matrix<double, 1, 1>(frame.n.dot(offset)), 1.0);
    }
    // Among more neighbors there are no fewer lines.
    if (lines <= kMostDegree + 1) lines = LinesOf(frame, neighbors.first(count));
    const auto take = [&](const std::optional<PointFit>& found, size_t degree) {
      // Across one line more than its degree a polynomial is free: whatever lines have in common, it leaves nothing.
      if (!found.has_value() || lines <= degree + 1) return;
      const double half = kHalfWidthOfHeights * found->mean_error;
      const double least = found->point.mean - half, most = found->point.mean + half;
      if (least > high || most < low) return;
      if (degree == kMostDegree) {
        low = std::max(low, least);
        high = std::min(high, most);
      }
      if (!best.has_value() || found->mean_error < best->mean_error) best = found;
    };
    const HeightsAround around{equations, count, radius, noise};
    const double reach = neighbors[count - 1]->offset.norm();
    take(FitHeights<2>(frame, around, reach), 2);
    take(FitHeights<kMostDegree>(frame, around, reach), kMostDegree);
  }
  return best;
}

}  // namespace curvd
