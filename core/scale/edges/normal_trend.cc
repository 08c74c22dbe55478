#include "core/scale/edges/normal_trend.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/scale/pilot/pilot_batch.h"
#include "core/scale/point_fits/normal_polynomials.h"
#include "core/scale/shapes/field_limits.h"

namespace curvd {

namespace {

using Eigen::Vector3d;

// What a polynomial of degree 4 leaves of what one of degree 2 leaves: 0.5 to 1 beside 19 in 20 edges, 0.12 to 0.45 of
// waves about as long as the neighborhood is wide.
constexpr double kMostOfBend = 0.5;

// The plane across the mean of normals.
struct MeanPlane {
  NormalFrame frame;
  double unit;  // one over the length that x and y are multiples of

  // Nothing where the normals have no mean, or all neighbors are at the point.
  static std::optional<MeanPlane> Of(std::span<const NeighborNormal> neighbors) {
    Vector3d sum = Vector3d::Zero();
    double squared = 0.0;
    for (const NeighborNormal& neighbor : neighbors) {
      sum += neighbor.normal;
      squared = std::max(squared, neighbor.offset.squaredNorm());
    }
    const double least = kLeastLengthOfMeanNormal * static_cast<double>(neighbors.size());
    if (!(sum.norm() > least) || !(squared > 0.0)) return std::nullopt;
    return MeanPlane{NormalFrame(sum.normalized()), 1.0 / std::sqrt(squared)};
  }
  double XOf(const NeighborNormal& neighbor) const { return unit * frame.u.dot(neighbor.offset); }
  double YOf(const NeighborNormal& neighbor) const { return unit * frame.v.dot(neighbor.offset); }
};

// The variance along each tangent of what the fit of that degree leaves of so many normals. Nothing where these are too
// few.
template <int kDegree>
std::optional<double> LeftOf(size_t count, const PolynomialFit<kDegree>& fit) {
  const double freedom = static_cast<double>(count) - kPolynomialTerms[kDegree];
  return freedom > 0.0 ? std::optional(0.5 * fit.squares / freedom) : std::nullopt;
}

// Equations of degree 2, summed with vectors: a quarter of a cloud's points ask for them.
PolynomialEquations<2> QuadraticEquations(std::span<const NeighborNormal> neighbors, const MeanPlane& plane) {
  std::array<double, MonomialCount(4)> monomials{};
  std::array<std::array<double, MonomialCount(2)>, 3> rights{};
  double squares = 0.0;
  PilotBatch batch;
  const auto add = [&] {
    AddMoments(batch, {.degree = 2,
                       .normal_degree = 2,
                       .plain = monomials.data(),
                       .height = nullptr,
                       .normal = {rights[0].data(), rights[1].data(), rights[2].data()}});
    batch.count = 0;
  };
  for (const NeighborNormal& neighbor : neighbors) {
    if (batch.is_full()) add();
    const Vector3d& normal = neighbor.normal;
    batch.Add({{plane.XOf(neighbor), plane.YOf(neighbor), 0.0}, {normal.x(), normal.y(), normal.z()}});
    squares += normal.squaredNorm();
  }
  add();
  return PolynomialEquations<2>::OfSums(static_cast<double>(neighbors.size()), monomials.data(),
                                        {rights[0].data(), rights[1].data(), rights[2].data()}, squares);
}

}  // namespace

NormalTrend TrendOf(std::span<const NeighborNormal> neighbors) {
  constexpr NormalTrend kNone = {std::numeric_limits<double>::quiet_NaN(), 0.0};
  const auto plane = MeanPlane::Of(neighbors);
  if (!plane.has_value()) return kNone;
  const auto fit = QuadraticEquations(neighbors, *plane).Solve();
  if (!fit.has_value()) return kNone;
  const auto left = LeftOf(neighbors.size(), *fit);
  if (!left.has_value()) return kNone;
  const Eigen::Matrix<double, 2, 3> slopes = fit->coefficients.middleRows<2>(1);
  // The root of the larger eigenvalue of the slopes' products.
  const Eigen::Matrix2d products = slopes * slopes.transpose();
  const double middle = 0.5 * products.trace();
  const double steepest = middle + std::sqrt(std::max(middle * middle - products.determinant(), 0.0));
  return {std::sqrt(*left), plane->unit * std::sqrt(steepest)};
}

bool AreOfBend(std::span<const NeighborNormal> neighbors) {
  const auto plane = MeanPlane::Of(neighbors);
  if (!plane.has_value()) return false;
  PolynomialEquations<4> equations;
  for (const NeighborNormal& neighbor : neighbors) {
    equations.Add(plane->XOf(neighbor), plane->YOf(neighbor), neighbor.normal, 1.0);
  }
  const auto low = equations.SolveDegree<2>();
  const auto high = equations.SolveDegree<4>();
  if (!low.has_value() || !high.has_value()) return false;
  const auto left_by_low = LeftOf(neighbors.size(), *low), left_by_high = LeftOf(neighbors.size(), *high);
  return left_by_high.has_value() && *left_by_high < kMostOfBend * kMostOfBend * *left_by_low;
}

}  // namespace curvd
