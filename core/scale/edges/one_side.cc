#include "core/scale/edges/one_side.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "Eigen/Cholesky"
#include "Eigen/Geometry"

namespace curvd {
namespace {

using Eigen::Vector3d;

constexpr std::array<int, 4> kTerms = {1, 3, 6, 10};  // of polynomials, by degree
// Pivots relative to the diagonal they began as, below which monomials depend on others.
constexpr double kLeastPivot = 1e-6;
// A normal belongs to the point's side if it differs from what is expected by less than so many standard deviations of
// noise, or than what an edge of 10 degrees makes.
constexpr double kMostDeviations = 4.0, kLeastTolerance = 0.17;
// Heights of a surface may differ from those which the normals at both ends give by this share of the distance.
constexpr double kHeightSlack = 0.1;
// The nearest neighbors, from which the rest is reached.
constexpr size_t kCore = 16;
// Fewer on the point's side say nothing.
constexpr size_t kLeastCount = 8;

struct Frame {
  Vector3d u, v, n;
  explicit Frame(const Vector3d& normal) : u(normal.unitOrthogonal()), v(normal.cross(u)), n(normal) {}
};

// The monomials of x and y up to a degree.
template <int kDegree>
Eigen::Matrix<double, kTerms[kDegree], 1> MonomialsAt(double x, double y) {
  Eigen::Matrix<double, kTerms[kDegree], 1> terms;
  terms[0] = 1.0;
  for (int n = 1, place = 1; n <= kDegree; ++n) {
    const int before = place - n;
    for (int j = 0; j < n; ++j) terms[place++] = x * terms[before + j];
    terms[place++] = y * terms[before + n - 1];
  }
  return terms;
}

template <int kDegree>
struct Fit {
  Eigen::LLT<Eigen::Matrix<double, kTerms[kDegree], kTerms[kDegree]>> factors;
  Eigen::Matrix<double, kTerms[kDegree], 3> coefficients;  // a row a monomial
  double squares;                                          // weighted, of what is left

  // The variance of the coefficient of x (1) or of y (2) where the normals' is 1.
  double Variance(int coefficient) const {
    using Column = Eigen::Matrix<double, kTerms[kDegree], 1>;
    const Column unit = Column::Unit(coefficient);
    const Column solution = factors.solve(unit);
    return solution[coefficient];
  }
};

// Normal equations of the fit of a polynomial to normals.
template <int kDegree>
class Equations {
 public:
  static constexpr int kSize = kTerms[kDegree];

  void Add(double x, double y, const Vector3d& normal, double weight) {
    const auto terms = MonomialsAt<kDegree>(x, y);
    matrix_.noalias() += (weight * terms) * terms.transpose();
    right_.noalias() += (weight * terms) * normal.transpose();
    weights_ += weight;
    squares_ += weight * normal.squaredNorm();
  }
  double weights() const { return weights_; }

  // Nothing where monomials depend on others.
  std::optional<Fit<kDegree>> Solve() const { return SolveDegree<kDegree>(); }

  // The fit of a polynomial of a lower degree.
  template <int kLower>
  std::optional<Fit<kLower>> SolveDegree() const {
    constexpr int kLowerSize = kTerms[kLower];
    using Matrix = Eigen::Matrix<double, kLowerSize, kLowerSize>;
    const Matrix matrix = matrix_.template topLeftCorner<kLowerSize, kLowerSize>();
    Fit<kLower> fit;
    fit.factors.compute(matrix);
    if (fit.factors.info() != Eigen::Success) return std::nullopt;
    for (int i = 0; i < kLowerSize; ++i) {
      const double pivot = fit.factors.matrixLLT()(i, i);
      if (!(pivot * pivot > kLeastPivot * matrix(i, i))) return std::nullopt;
    }
    // One column after the other: Eigen sets up for large matrices where there are several.
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Matrix<double, kLowerSize, 1> right = right_.template topRows<kLowerSize>().col(axis);
      fit.coefficients.col(axis) = fit.factors.solve(right);
    }
    fit.squares = std::max(squares_ - fit.coefficients.cwiseProduct(right_.template topRows<kLowerSize>()).sum(), 0.0);
    return fit;
  }

 private:
  Eigen::Matrix<double, kSize, kSize> matrix_ = Eigen::Matrix<double, kSize, kSize>::Zero();
  Eigen::Matrix<double, kSize, 3> right_ = Eigen::Matrix<double, kSize, 3>::Zero();
  double weights_ = 0.0, squares_ = 0.0;
};

// The mean of the normals near `normal` among the nearest neighbors.
std::optional<Vector3d> NormalOfSide(std::span<const SideNeighbor> neighbors, Vector3d normal, double tolerance) {
  for (int round = 0; round < 3; ++round) {
    Vector3d sum = Vector3d::Zero();
    for (const SideNeighbor& neighbor : neighbors) {
      if ((neighbor.normal - normal).squaredNorm() < tolerance * tolerance) sum += neighbor.normal;
    }
    if (!(sum.norm() > 0.5)) return std::nullopt;
    normal = sum.normalized();
  }
  return normal;
}

// Picks the neighbors on the side of a point.
class SidePicker {
 public:
  SidePicker(const Frame& frame, const SideLimits& limits)
      : frame_(frame),
        limits_(limits),
        tolerance_(std::max(kMostDeviations * limits.normal_noise, kLeastTolerance)),
        heights_(kMostDeviations * limits.height_noise) {}

  const std::vector<const SideNeighbor*>& Pick(std::span<const SideNeighbor> neighbors) {
    for (size_t first = 0, last = std::min(kCore, neighbors.size()); first < last && picked_.size() < limits_.count;) {
      const double unit = neighbors[last - 1].offset.norm();
      if (unit > 0.0) PickRing(neighbors.subspan(first, last - first), unit);
      first = last;
      last = std::min(neighbors.size(), last + last / 2);
    }
    return picked_;
  }

 private:
  void PickRing(std::span<const SideNeighbor> ring, double unit) {
    // Once enough are known, their linear trend tells what comes next.
    std::optional<Fit<1>> trend;
    if (picked_.size() >= kLeastCount) {
      Equations<1> equations;
      for (const SideNeighbor* const picked : picked_) {
        equations.Add(frame_.u.dot(picked->offset) / unit, frame_.v.dot(picked->offset) / unit, picked->normal, 1.0);
      }
      trend = equations.Solve();
    }
    for (const SideNeighbor& neighbor : ring) {
      Vector3d expected = frame_.n;
      if (trend.has_value()) {
        const double x = frame_.u.dot(neighbor.offset) / unit, y = frame_.v.dot(neighbor.offset) / unit;
        expected = (trend->coefficients.transpose() * MonomialsAt<1>(x, y)).normalized();
      }
      const double height = 0.5 * (expected + frame_.n).dot(neighbor.offset);
      if ((neighbor.normal - expected).squaredNorm() < tolerance_ * tolerance_ &&
          std::abs(height) <= heights_ + kHeightSlack * neighbor.offset.norm()) {
        picked_.push_back(&neighbor);
      }
    }
  }

  const Frame& frame_;
  const SideLimits& limits_;
  const double tolerance_, heights_;
  std::vector<const SideNeighbor*> picked_;
};

std::array<float, 3> ToFloats(const Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

// The curvature of a field of normals over the plane of a frame, by its value and derivatives at the origin
// (docs/numerics.md).
template <int kDegree>
std::optional<PointCurvature> CurvatureOf(const Frame& frame, const Fit<kDegree>& fit, double radius) {
  const Vector3d value = fit.coefficients.row(0), along_x = fit.coefficients.row(1), along_y = fit.coefficients.row(2);
  const double length = value.norm();
  const Vector3d normal = value / length;
  if (!(frame.n.dot(normal) > 0.1)) return std::nullopt;
  const Vector3d s = normal.unitOrthogonal(), t = normal.cross(s);
  const auto change = [&](const Vector3d& tangent) -> Vector3d {
    return (tangent.dot(frame.u) * along_x + tangent.dot(frame.v) * along_y) / (length * radius);
  };
  const double ss = change(s).dot(s), tt = change(t).dot(t), st = 0.5 * (change(s).dot(t) + change(t).dot(s));
  const double mean = 0.5 * (ss + tt), half = 0.5 * (ss - tt), difference = std::hypot(half, st);
  const double angle = 0.5 * std::atan2(st, half);
  const Vector3d d2 = std::cos(angle) * s + std::sin(angle) * t;
  const PointCurvature point = {static_cast<float>(mean),
                                static_cast<float>((mean - difference) * (mean + difference)),
                                static_cast<float>(mean - difference),
                                static_cast<float>(mean + difference),
                                ToFloats(d2.cross(normal)),
                                ToFloats(d2),
                                static_cast<float>(radius),
                                PointStatus::kOk};
  const bool is_finite = std::isfinite(point.gaussian) && std::isfinite(point.k1) && std::isfinite(point.k2);
  return is_finite ? std::optional(point) : std::nullopt;
}

// What a fit of that degree says, if chance makes no larger error of it.
template <int kDegree>
std::optional<PointCurvature> CurvatureInDegree(const Frame& frame, const Equations<3>& equations, size_t count,
                                                double radius, double allowed_error) {
  const double freedom = static_cast<double>(count) - kTerms[kDegree];
  if (!(freedom > 0.0)) return std::nullopt;
  const auto fit = equations.SolveDegree<kDegree>();
  if (!fit.has_value()) return std::nullopt;
  const double variance = 0.5 * fit->squares / equations.weights() * static_cast<double>(count) / freedom;
  const double error = 0.5 * std::sqrt(variance * (fit->Variance(1) + fit->Variance(2))) / radius;
  return error <= allowed_error ? CurvatureOf(frame, *fit, radius) : std::nullopt;
}

}  // namespace

NormalTrend TrendOf(std::span<const SideNeighbor> neighbors) {
  constexpr int kDegree = 2, kSize = kTerms[kDegree];
  constexpr NormalTrend kNone = {std::numeric_limits<double>::quiet_NaN(), 0.0};
  Vector3d sum = Vector3d::Zero();
  double squared = 0.0;
  for (const SideNeighbor& neighbor : neighbors) {
    sum += neighbor.normal;
    squared = std::max(squared, neighbor.offset.squaredNorm());
  }
  if (!(sum.norm() > 0.1 * static_cast<double>(neighbors.size())) || !(squared > 0.0)) return kNone;
  const Frame frame(sum.normalized());
  const double unit = 1.0 / std::sqrt(squared);
  Equations<kDegree> equations;
  for (const SideNeighbor& neighbor : neighbors) {
    equations.Add(unit * frame.u.dot(neighbor.offset), unit * frame.v.dot(neighbor.offset), neighbor.normal, 1.0);
  }
  const auto fit = equations.Solve();
  const double freedom = static_cast<double>(neighbors.size()) - kSize;
  if (!fit.has_value() || !(freedom > 0.0)) return kNone;
  const Eigen::Matrix<double, 2, 3> slopes = fit->coefficients.middleRows<2>(1);
  // The root of the larger eigenvalue of the slopes' products.
  const Eigen::Matrix2d products = slopes * slopes.transpose();
  const double middle = 0.5 * products.trace();
  const double steepest = middle + std::sqrt(std::max(middle * middle - products.determinant(), 0.0));
  return {std::sqrt(0.5 * fit->squares / freedom), unit * std::sqrt(steepest)};
}

std::optional<PointCurvature> EstimateOneSide(std::span<const SideNeighbor> neighbors, const Vector3d& normal,
                                              const SideLimits& limits) {
  const double tolerance = std::max(kMostDeviations * limits.normal_noise, kLeastTolerance);
  const auto side = NormalOfSide(neighbors.first(std::min(kCore, neighbors.size())), normal, tolerance);
  if (!side.has_value()) return std::nullopt;
  const Frame frame(*side);
  SidePicker picker(frame, limits);
  const std::vector<const SideNeighbor*>& picked = picker.Pick(neighbors);
  if (picked.size() < kLeastCount) return std::nullopt;
  const double radius = picked.back()->offset.norm();
  if (!(radius > 0.0)) return std::nullopt;
  Equations<3> equations;
  for (const SideNeighbor* const neighbor : picked) {
    const double x = frame.u.dot(neighbor->offset) / radius, y = frame.v.dot(neighbor->offset) / radius;
    equations.Add(x, y, neighbor->normal, std::max(1.0 - x * x - y * y, 0.0));
  }
  if (auto point = CurvatureInDegree<3>(frame, equations, picked.size(), radius, limits.allowed_error)) return point;
  if (auto point = CurvatureInDegree<2>(frame, equations, picked.size(), radius, limits.allowed_error)) return point;
  return CurvatureInDegree<1>(frame, equations, picked.size(), radius, std::numeric_limits<double>::infinity());
}

}  // namespace curvd
