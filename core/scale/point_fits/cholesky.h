// Solves normal equations of a few unknowns.
#pragma once

#include <cmath>

#include "Eigen/Core"

namespace curvd {

// The Cholesky factors of a symmetric matrix of doubles. The loops have fixed bounds, so that compilers unroll them:
// for the sizes of polynomials that is several times as fast as Eigen::LLT, which works block by block.
template <int kSize>
class Cholesky {
 public:
  using Matrix = Eigen::Matrix<double, kSize, kSize>;

  // Reads the lower triangle. Returns whether the matrix is positive definite beyond rounding: each pivot is more than
  // this part of the diagonal that it began as. Otherwise the object is of no use.
  bool Compute(const Matrix& matrix, double least_pivot) {
    for (int k = 0; k < kSize; ++k) {
      for (int row = k; row < kSize; ++row) columns_[k][row] = matrix(row, k);
    }
    for (int k = 0; k < kSize; ++k) {
      double* const pivots = columns_[k];
      const double pivot = pivots[k];
      if (!(pivot > least_pivot * matrix(k, k))) return false;  // NaN included
      inverse_[k] = 1.0 / std::sqrt(pivot);
      for (int row = k + 1; row < kSize; ++row) pivots[row] *= inverse_[k];
      for (int column = k + 1; column < kSize; ++column) {
        const double factor = pivots[column];
        for (int row = column; row < kSize; ++row) columns_[column][row] -= factor * pivots[row];
      }
    }
    return true;
  }

  // REQUIRES: Compute has returned true.
  template <int kColumns>
  Eigen::Matrix<double, kSize, kColumns> Solve(Eigen::Matrix<double, kSize, kColumns> right) const {
    for (int k = 0; k < kSize; ++k) {
      for (int c = 0; c < kColumns; ++c) {
        const double solved = right(k, c) * inverse_[k];
        right(k, c) = solved;
        for (int row = k + 1; row < kSize; ++row) right(row, c) -= solved * columns_[k][row];
      }
    }
    for (int k = kSize - 1; k >= 0; --k) {
      for (int c = 0; c < kColumns; ++c) {
        double sum = right(k, c);
        for (int row = k + 1; row < kSize; ++row) sum -= right(row, c) * columns_[k][row];
        right(k, c) = sum * inverse_[k];
      }
    }
    return right;
  }

 private:
  double columns_[kSize][kSize];  // of the lower triangle
  double inverse_[kSize];         // of the factors' diagonal
};

}  // namespace curvd
