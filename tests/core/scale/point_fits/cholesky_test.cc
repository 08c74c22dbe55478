#include "core/scale/point_fits/cholesky.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "Eigen/LU"

namespace curvd::testing {
namespace {

template <int kSize>
void ExpectSolved() {
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  using Right = Eigen::Matrix<double, kSize, 3>;
  std::mt19937_64 random(kSize);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 20; ++round) {
    const Matrix root = Matrix::NullaryExpr([&] { return normal(random); });
    Matrix matrix = root * root.transpose() + 0.1 * Matrix::Identity();
    const Right expected = Right::NullaryExpr([&] { return normal(random); });
    const Right right = matrix * expected;
    // The upper triangle is not read.
    matrix.template triangularView<Eigen::StrictlyUpper>().setConstant(std::nan(""));
    Cholesky<kSize> factors;
    ASSERT_TRUE(factors.Compute(matrix, 1e-6));
    EXPECT_LT((factors.Solve(right) - expected).cwiseAbs().maxCoeff(), 1e-9 * (1.0 + expected.cwiseAbs().maxCoeff()));
  }
}

TEST(CholeskyTest, SolvesEquationsOfEachSize) {
  ExpectSolved<1>();
  ExpectSolved<3>();
  ExpectSolved<6>();
  ExpectSolved<15>();
}

TEST(CholeskyTest, RefusesWhatHasNoSolution) {
  Cholesky<2> factors;
  Eigen::Matrix2d matrix;
  matrix << 1.0, 1.0, 1.0, 1.0;
  EXPECT_FALSE(factors.Compute(matrix, 1e-6));
  matrix(1, 1) = 1.0 + 0.9e-6;
  EXPECT_FALSE(factors.Compute(matrix, 1e-6));
  matrix(1, 1) = 1.0 + 2e-6;
  EXPECT_TRUE(factors.Compute(matrix, 1e-6));
  matrix(1, 0) = 2.0;
  EXPECT_FALSE(factors.Compute(matrix, 1e-6));
  matrix(1, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(factors.Compute(matrix, 1e-6));
  EXPECT_FALSE(factors.Compute(Eigen::Matrix2d::Zero(), 1e-6));
}

}  // namespace
}  // namespace curvd::testing
