#include "core/scale/pilot/pilot_fits.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Geometry"
#include "core/scale/pilot/pilot_systems.h"
#include "core/scale/shapes/field_limits.h"
#include "core/scale/shapes/linear_shape.h"

namespace curvd {
namespace {

using Eigen::Vector3d;

// Of the weights 1 - x^2 - y^2 over a disc, the mean of their squares over their mean.
constexpr double kMeanWeightInFit = 2.0 / 3.0;
// Neighbors more than a fit has coefficients, from which its residual says something.
constexpr double kLeastFreedom = 4.0;
// A jet of degree 6 of fewer neighbors for each coefficient mostly has pivots that lose digits.
constexpr double kLeastPerSexticCoefficient = 1.5;

// Coefficients up to degree 2, a column for each component of the normal, which has unit length at the point.
using NormalFit = Eigen::Matrix<double, static_cast<int>(MonomialCount(2)), 3>;

// The shape operator of a fit to the normals, whose value at the point has unit length.
TangentShape ShapeOfNormals(const NormalFit& fit) {
  const Vector3d unit = fit.row(IndexOf(0, 0)), dx = fit.row(IndexOf(1, 0)), dy = fit.row(IndexOf(0, 1));
  const Vector3d tangent_x(1.0, 0.0, -unit.x() / unit.z()), tangent_y(0.0, 1.0, -unit.y() / unit.z());
  const auto along_sphere = [&](const Vector3d& d) -> Vector3d { return d - d.dot(unit) * unit; };
  return ShapeOf(tangent_x, tangent_y, along_sphere(dx), along_sphere(dy));
}

// A shape in units of `unit`.
TangentShape InUnits(const TangentShape& shape, double unit) {
  return {shape.mean / unit, shape.difference / unit, shape.twist / unit};
}

// Slopes of the shape operator at the origin of a regression's fit, in units of `squared_unit`: those of the symmetric
// part of the derivatives of the normals' x and y.
std::array<TangentShape, 2> SlopesOf(const NormalFit& fit, double squared_unit) {
  const auto second = [&](int i, int j, int axis) {
    return (i == 1 ? 1.0 : 2.0) * fit(IndexOf(i, j), axis) / squared_unit;
  };
  const auto along = [&](int i, int j) {  // of x^i y^j along x, of x^(i-1) y^(j+1) along y
    return TangentShape{0.5 * (second(i, j, 0) + second(i - 1, j + 1, 1)),
                        0.5 * (second(i, j, 0) - second(i - 1, j + 1, 1)),
                        0.5 * (second(i - 1, j + 1, 0) + second(i, j, 1))};
  };
  return {along(2, 0), along(1, 1)};
}

// The fit of one neighborhood, its coefficients up to degree 2 alone. Nothing if it is none of a surface.
std::optional<NormalFit> NormalFitOf(const PilotSolutions& solutions, size_t lane) {
  NormalFit fit;
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < fit.rows(); ++k) {
      fit(k, axis) = solutions.coefficients[static_cast<size_t>(axis)][static_cast<size_t>(k)][lane];
    }
  }
  const Vector3d at_point = fit.row(IndexOf(0, 0));
  const double length = at_point.norm();
  if (!(length > kLeastLengthOfMeanNormal) || !(at_point.z() > kLeastCosineToFrame * length)) return std::nullopt;
  fit /= length;
  return fit;
}

}  // namespace

void PilotFitter::Add(const PilotSums& sums, double distinct, double radius) {
  const size_t lane = size_++;
  linear_[lane] = methods_[kLinearRegressionMethod] ? LinearShapeOf(sums, distinct) : std::nullopt;
  distinct_[lane] = distinct;
  count_[lane] = sums.count();
  radius_[lane] = radius;
  height_squares_[lane] = sums.height_squares();
  with_sextic_[lane] =
      sums.has_sextic() && distinct >= kLeastPerSexticCoefficient * MonomialCount(PilotSums::kSexticDegree);
  const int degree = with_sextic_[lane] ? PilotSums::kSexticDegree : PilotSums::kQuarticDegree;
  for (size_t k = 0; k < MonomialCount(2 * degree); ++k) moments_[k][lane] = sums.moments()[k];
  for (size_t k = 0; k < MonomialCount(degree); ++k) heights_[k][lane] = sums.heights()[k];
  for (size_t axis = 0; axis < 3; ++axis) {
    for (size_t k = 0; k < PilotSums::kNormalCount; ++k) normals_[axis][k][lane] = sums.normals(axis)[k];
  }
}

std::array<PilotFits, PilotFitter::kMost> PilotFitter::Fit() {
  std::array<PilotFits, kMost> fits;
  for (size_t lane = 0; lane < size_; ++lane) fits[lane].linear_regression = linear_[lane];
  PilotSolutions solutions;
  FitCubicNormals(solutions, fits);
  if (methods_[kQuadraticRegressionMethod]) FitQuadraticNormals(solutions, fits);
  FitJets(4, &PilotFits::quartic, solutions, fits);
  if (methods_[kQuadricMethod]) FitJets(2, &PilotFits::quadric, solutions, fits);
  if (methods_[kSexticMethod]) FitJets(PilotSums::kSexticDegree, &PilotFits::sextic, solutions, fits);
  size_ = 0;
  return fits;
}

void PilotFitter::SolveNormals(int degree, PilotSolutions& solutions) const {
  SolveWeighted(degree,
                {size_,
                 count_.data(),
                 radius_.data(),
                 moments_.front().data(),
                 {normals_[0].front().data(), normals_[1].front().data(), normals_[2].front().data()}},
                solutions);
  for (size_t lane = 0; lane < size_; ++lane) {
    if (distinct_[lane] < static_cast<double>(MonomialCount(degree)) + kLeastFreedom) solutions.are_fixed[lane] = false;
  }
}

void PilotFitter::FitCubicNormals(PilotSolutions& solutions, Fits& fits) const {
  constexpr int kDegree = 3;
  SolveNormals(kDegree, solutions);
  for (size_t lane = 0; lane < size_; ++lane) {
    if (!solutions.are_fixed[lane]) continue;
    const auto fit = NormalFitOf(solutions, lane);
    if (!fit.has_value()) continue;
    // The normals have unit length, so that the sum of their squares is that of the weights.
    const double weight = solutions.weight[lane], radius = radius_[lane];
    const double freedom = 2.0 * (weight - kMeanWeightInFit * MonomialCount(kDegree) / distinct_[lane]);
    fits[lane].regression = {InUnits(ShapeOfNormals(*fit), radius), SlopesOf(*fit, radius * radius),
                             std::sqrt(std::max(weight - solutions.explained[lane], 0.0) / freedom)};
  }
}

void PilotFitter::FitQuadraticNormals(PilotSolutions& solutions, Fits& fits) const {
  SolveNormals(2, solutions);
  for (size_t lane = 0; lane < size_; ++lane) {
    if (!solutions.are_fixed[lane]) continue;
    if (const auto fit = NormalFitOf(solutions, lane)) {
      fits[lane].quadratic_regression = InUnits(ShapeOfNormals(*fit), radius_[lane]);
    }
  }
}

void PilotFitter::FitJets(int degree, std::optional<PilotFits::Jet> PilotFits::*jet, PilotSolutions& solutions,
                          Fits& fits) const {
  const bool is_sextic = degree == PilotSums::kSexticDegree;
  size_t size = size_;
  // Larger neighborhoods, which come last, have none.
  while (is_sextic && size > 0 && !with_sextic_[size - 1]) --size;
  SolveUnweighted(
      degree,
      {size, count_.data(), radius_.data(), moments_.front().data(), {heights_.front().data(), nullptr, nullptr}},
      solutions);
  const auto coefficients = static_cast<double>(MonomialCount(degree));
  for (size_t lane = 0; lane < size; ++lane) {
    const double count = count_[lane], distinct = distinct_[lane], radius = radius_[lane];
    if (!solutions.are_fixed[lane] || distinct < coefficients + 1.0 || (is_sextic && !with_sextic_[lane])) continue;
    // Heights are in the unit of the neighbors.
    const auto fit = [&](int i, int j) {
      return solutions.coefficients[0][static_cast<size_t>(IndexOf(i, j))][lane] / radius;
    };
    const double squares = (height_squares_[lane] / count - solutions.explained[lane]) / (radius * radius);
    const double p = fit(1, 0), q = fit(0, 1), w = std::sqrt(1.0 + p * p + q * q);
    const double xx = -2.0 * fit(2, 0) / w, xy = -fit(1, 1) / w, yy = -2.0 * fit(0, 2) / w;
    fits[lane].*jet = PilotFits::Jet{InUnits(ShapeOf(1.0 + p * p, p * q, 1.0 + q * q, xx, xy, yy), radius),
                                     std::sqrt(std::max(squares, 0.0) * distinct / (distinct - coefficients)) * radius};
  }
}

}  // namespace curvd
