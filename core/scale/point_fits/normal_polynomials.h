// Polynomials that are fitted to the normals of neighbors, over a plane.
#pragma once

#include <algorithm>
#include <array>
#include <optional>

#include "Eigen/Core"
#include "Eigen/Geometry"
#include "core/scale/point_fits/cholesky.h"

namespace curvd {

// Monomials in a polynomial of two variables, by its degree.
inline constexpr std::array<int, 5> kPolynomialTerms = {1, 3, 6, 10, 15};

// A normal and two axes across it.
struct NormalFrame {
  Eigen::Vector3d u, v, n;
  explicit NormalFrame(const Eigen::Vector3d& normal) : u(normal.unitOrthogonal()), v(normal.cross(u)), n(normal) {}
};

// The monomials of x and y up to a degree.
template <int kDegree>
Eigen::Matrix<double, kPolynomialTerms[kDegree], 1> MonomialsAt(double x, double y) {
  Eigen::Matrix<double, kPolynomialTerms[kDegree], 1> terms;
  terms[0] = 1.0;
  for (int n = 1, place = 1; n <= kDegree; ++n) {
    const int before = place - n;
    for (int j = 0; j < n; ++j) terms[place++] = x * terms[before + j];
    terms[place++] = y * terms[before + n - 1];
  }
  return terms;
}

// A polynomial for each axis of the normals, or of other values.
template <int kDegree, int kAxes = 3>
struct PolynomialFit {
  Cholesky<kPolynomialTerms[kDegree]> factors;
  Eigen::Matrix<double, kPolynomialTerms[kDegree], kAxes> coefficients;  // a row a monomial
  double squares;                                                        // weighted, of what is left

  // The variance of a coefficient, as that of x (1) or of y (2), where the values' is 1.
  double Variance(int coefficient) const { return Weights(coefficient)[coefficient]; }
  // How much the right sides of the equations count in a coefficient.
  Eigen::Matrix<double, kPolynomialTerms[kDegree], 1> Weights(int coefficient) const {
    using Column = Eigen::Matrix<double, kPolynomialTerms[kDegree], 1>;
    const Column unit = Column::Unit(coefficient);
    return factors.Solve(unit);
  }
};

// Normal equations of the fit of a polynomial to normals, or to other values of as many axes.
template <int kDegree, int kAxes = 3>
class PolynomialEquations {
 public:
  static constexpr int kSize = kPolynomialTerms[kDegree];

  // Of `count` values of weight 1: the sums of x^i y^j up to twice the degree, and of each axis of the values times
  // x^i y^j up to the degree, as graded monomials; and of the values squared.
  static PolynomialEquations OfSums(double count, const double* monomials,
                                    const std::array<const double*, kAxes>& rights, double squares) {
    PolynomialEquations made;
    for (int q = 0, column = 0; q <= kDegree; ++q) {
      for (int b = 0; b <= q; ++b, ++column) {
        for (int p = 0, row = 0; p <= kDegree; ++p) {
          for (int a = 0; a <= p; ++a, ++row) {
            const int degree = p + q;
            made.matrix_(row, column) = monomials[degree * (degree + 1) / 2 + a + b];
          }
        }
        for (int axis = 0; axis < kAxes; ++axis) {
          made.right_(column, axis) = rights[static_cast<size_t>(axis)][column];
        }
      }
    }
    made.weights_ = count;
    made.squares_ = squares;
    return made;
  }

  void Add(double x, double y, const Eigen::Matrix<double, kAxes, 1>& value, double weight) {
    const auto terms = MonomialsAt<kDegree>(x, y);
    matrix_.noalias() += (weight * terms) * terms.transpose();
    right_.noalias() += (weight * terms) * value.transpose();
    weights_ += weight;
    squares_ += weight * value.squaredNorm();
  }
  // Adds the equations of other neighbors, or of the same with other weights, times a factor.
  void AddTimes(double factor, const PolynomialEquations& other) {
    matrix_ += factor * other.matrix_;
    right_ += factor * other.right_;
    weights_ += factor * other.weights_;
    squares_ += factor * other.squares_;
  }
  double weights() const { return weights_; }

  // Nothing where monomials depend on others.
  std::optional<PolynomialFit<kDegree, kAxes>> Solve() const { return SolveDegree<kDegree>(); }

  // The fit of a polynomial of a lower degree.
  template <int kLower>
  std::optional<PolynomialFit<kLower, kAxes>> SolveDegree() const {
    constexpr int kLowerSize = kPolynomialTerms[kLower];
    using Matrix = Eigen::Matrix<double, kLowerSize, kLowerSize>;
    const Matrix matrix = matrix_.template topLeftCorner<kLowerSize, kLowerSize>();
    PolynomialFit<kLower, kAxes> fit;
    if (!fit.factors.Compute(matrix, kLeastPivot)) return std::nullopt;
    const Eigen::Matrix<double, kLowerSize, kAxes> right = right_.template topRows<kLowerSize>();
    fit.coefficients = fit.factors.Solve(right);
    fit.squares = std::max(squares_ - fit.coefficients.cwiseProduct(right).sum(), 0.0);
    return fit;
  }

 private:
  // Pivots relative to the diagonal they began as, below which monomials depend on others.
  static constexpr double kLeastPivot = 1e-6;

  Eigen::Matrix<double, kSize, kSize> matrix_ = Eigen::Matrix<double, kSize, kSize>::Zero();
  Eigen::Matrix<double, kSize, kAxes> right_ = Eigen::Matrix<double, kSize, kAxes>::Zero();
  double weights_ = 0.0, squares_ = 0.0;
};

}  // namespace curvd
