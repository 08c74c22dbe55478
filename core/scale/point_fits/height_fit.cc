#include "core/scale/point_fits/height_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/estimators/scale_ladder.h"
#include "core/scale/point_fits/field_curvature.h"

namespace curvd {
namespace {

using Eigen::Matrix3d;
using Heights = PolynomialEquations<4, 1>;

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

// Lines are parted by gaps of more than this share of the radius, and are narrower than this share of each gap.
constexpr double kLeastGapOfLines = 0.2, kMostWidthOfLines = 0.25;
// The line through a point goes through one of its nearest neighbors.
constexpr size_t kNearestOnLine = 3;

// On how many lines of a scanner the neighbors lie, all of one direction; their own number if they do not.
size_t LinesOf(const NormalFrame& frame, std::span<const NeighborNormal* const> neighbors) {
  size_t fewest = neighbors.size(), tried = 0;
  const double radius = neighbors.back()->offset.norm();
  std::vector<double> across(neighbors.size());
  for (size_t k = 0; k < neighbors.size() && tried < kNearestOnLine; ++k) {
    const double x = frame.u.dot(neighbors[k]->offset), y = frame.v.dot(neighbors[k]->offset);
    const double length = std::hypot(x, y);
    if (!(length > 0.0)) continue;
    ++tried;
    for (size_t i = 0; i < neighbors.size(); ++i) {
      across[i] = (y * frame.u - x * frame.v).dot(neighbors[i]->offset) / length;
    }
    std::sort(across.begin(), across.end());
    size_t lines = 1;
    double widest = 0.0, least_gap = radius, first = across.front();
    for (size_t i = 1; i < across.size(); ++i) {
      const double gap = across[i] - across[i - 1];
      if (gap > kLeastGapOfLines * radius) {
        widest = std::max(widest, across[i - 1] - first);
        least_gap = std::min(least_gap, gap);
        first = across[i];
        ++lines;
      }
    }
    widest = std::max(widest, across.back() - first);
    if (widest <= kMostWidthOfLines * least_gap) fewest = std::min(fewest, lines);
  }
  return fewest;
}

// What is known of the neighbors of a fit. Lengths are in units of `unit`.
struct HeightsAround {
  const Heights& equations;
  size_t count;
  size_t lines;  // that they lie on
  double unit;
  double noise;  // of the positions
};

// The fit of so many neighbors.
template <int kDegree>
std::optional<PointFit> FitHeights(const NormalFrame& frame, const HeightsAround& around, double radius) {
  const auto& [equations, count, lines, unit, noise] = around;
  const double freedom = static_cast<double>(count) - kPolynomialTerms[kDegree];
  if (freedom < kLeastFreedomOfHeights) return std::nullopt;
  // Across one line more than its degree a polynomial is free: whatever lines have in common, it leaves nothing.
  if (lines <= kDegree + 1) return std::nullopt;
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
  const auto take = [&](const std::optional<PointFit>& found) {
    if (found.has_value() && (!best.has_value() || found->mean_error < best->mean_error)) best = found;
  };
  size_t added = 0;
  for (const uint32_t count : kScaleRungs) {
    if (count < least_count) continue;
    if (count > neighbors.size()) break;
    for (; added < count; ++added) {
      const Eigen::Vector3d offset = neighbors[added]->offset / radius;
      equations.Add(frame.u.dot(offset), frame.v.dot(offset), Eigen::Matrix<double, 1, 1>(frame.n.dot(offset)), 1.0);
    }
    const double reach = neighbors[count - 1]->offset.norm();
    const HeightsAround around{equations, count, LinesOf(frame, neighbors.first(count)), radius, noise};
    take(FitHeights<2>(frame, around, reach));
    take(FitHeights<4>(frame, around, reach));
  }
  return best;
}

}  // namespace curvd
