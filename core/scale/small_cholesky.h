// Solves small systems of normal equations.
#pragma once

#include <cmath>

#include "Eigen/Core"

namespace curvd {

// The Cholesky factors of a symmetric matrix, in plain loops: Eigen's, of a size that is known as well, call functions
// for matrices of any size.
template <int kSize>
class SmallCholesky {
 public:
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  using Column = Eigen::Matrix<double, kSize, 1>;

  // Returns false if a pivot is not above `least_pivot`, NaN included; then there is nothing to solve. Reads the lower
  // triangle alone.
  bool Compute(const Matrix& matrix, double least_pivot) {
    for (int column = 0; column < kSize; ++column) {
      for (int row = column; row < kSize; ++row) lower_[column][row] = matrix(row, column);
    }
    for (int k = 0; k < kSize; ++k) {
      double* const pivots = lower_[k];
      if (!(pivots[k] > least_pivot)) return false;
      inverse_[k] = 1.0 / std::sqrt(pivots[k]);
      for (int row = k + 1; row < kSize; ++row) pivots[row] *= inverse_[k];
      for (int column = k + 1; column < kSize; ++column) {
        const double factor = pivots[column];
        for (int row = column; row < kSize; ++row) lower_[column][row] -= factor * pivots[row];
      }
    }
    return true;
  }

  // REQUIRES: Compute has returned true.
  Column Solve(Column right) const {
    for (int k = 0; k < kSize; ++k) {
      right[k] *= inverse_[k];
      for (int row = k + 1; row < kSize; ++row) right[row] -= right[k] * lower_[k][row];
    }
    for (int k = kSize - 1; k >= 0; --k) {
      for (int row = k + 1; row < kSize; ++row) right[k] -= right[row] * lower_[k][row];
      right[k] *= inverse_[k];
    }
    return right;
  }

 private:
  double lower_[kSize][kSize];  // column by column
  double inverse_[kSize];       // of the factor's diagonal
};

}  // namespace curvd
