#include "core/scale/edges/normal_trend.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/scale/point_fits/normal_polynomials.h"

namespace curvd {

namespace {

using Eigen::Vector3d;

// What a polynomial of degree 4 leaves of what one of degree 2 leaves: 0.5 to 1 beside 19 in 20 edges, 0.12 to 0.45 of
// waves about as long as the neighborhood is wide.
constexpr double kMostOfBend = 0.5;

// Equations for the normals over the plane across their mean.
template <int kDegree>
struct EquationsOverPlane {
  PolynomialEquations<kDegree> equations;
  double unit;  // one over the length that x and y are multiples of
  double count;

  // Nothing where the normals have no mean, or all neighbors are at the point.
  static std::optional<EquationsOverPlane> Of(std::span<const NeighborNormal> neighbors) {
    EquationsOverPlane made{{}, 0.0, static_cast<double>(neighbors.size())};
    Vector3d sum = Vector3d::Zero();
    double squared = 0.0;
    for (const NeighborNormal& neighbor : neighbors) {
      sum += neighbor.normal;
      squared = std::max(squared, neighbor.offset.squaredNorm());
    }
    if (!(sum.norm() > 0.1 * made.count) || !(squared > 0.0)) return std::nullopt;
    const NormalFrame frame(sum.normalized());
    made.unit = 1.0 / std::sqrt(squared);
    for (const NeighborNormal& neighbor : neighbors) {
      const double x = made.unit * frame.u.dot(neighbor.offset), y = made.unit * frame.v.dot(neighbor.offset);
      made.equations.Add(x, y, neighbor.normal, 1.0);
    }
    return made;
  }

  // The variance along each tangent of what the fit of that degree leaves. Nothing where neighbors are too few.
  template <int kFitDegree>
  std::optional<double> Left(const PolynomialFit<kFitDegree>& fit) const {
    const double freedom = count - kPolynomialTerms[kFitDegree];
    return freedom > 0.0 ? std::optional(0.5 * fit.squares / freedom) : std::nullopt;
  }
};

}  // namespace

NormalTrend TrendOf(std::span<const NeighborNormal> neighbors) {
  constexpr NormalTrend kNone = {std::numeric_limits<double>::quiet_NaN(), 0.0};
  const auto over_plane = EquationsOverPlane<2>::Of(neighbors);
  if (!over_plane.has_value()) return kNone;
  const auto fit = over_plane->equations.Solve();
  if (!fit.has_value()) return kNone;
  const auto left = over_plane->Left(*fit);
  if (!left.has_value()) return kNone;
  const Eigen::Matrix<double, 2, 3> slopes = fit->coefficients.middleRows<2>(1);
  // The root of the larger eigenvalue of the slopes' products.
  const Eigen::Matrix2d products = slopes * slopes.transpose();
  const double middle = 0.5 * products.trace();
  const double steepest = middle + std::sqrt(std::max(middle * middle - products.determinant(), 0.0));
  return {std::sqrt(*left), over_plane->unit * std::sqrt(steepest)};
}

bool AreOfBend(std::span<const NeighborNormal> neighbors) {
  const auto over_plane = EquationsOverPlane<4>::Of(neighbors);
  if (!over_plane.has_value()) return false;
  const auto low = over_plane->equations.SolveDegree<2>();
  const auto high = over_plane->equations.SolveDegree<4>();
  if (!low.has_value() || !high.has_value()) return false;
  const auto left_by_low = over_plane->Left(*low), left_by_high = over_plane->Left(*high);
  return left_by_high.has_value() && *left_by_high < kMostOfBend * kMostOfBend * *left_by_low;
}

}  // namespace curvd
