#include "core/scale/small_cholesky.h"

#include <gtest/gtest.h>

#include <limits>

#include "Eigen/Cholesky"

namespace curvd::testing {
namespace {

template <int kSize>
void SolvesAsEigenDoes() {
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  using Column = Eigen::Matrix<double, kSize, 1>;
  const Matrix random = Matrix::Random(), matrix = random * random.transpose() + Matrix::Identity();
  const Column right = Column::Random();
  SmallCholesky<kSize> factors;
  ASSERT_TRUE(factors.Compute(matrix, 1e-10));
  const Column expected = Eigen::LLT<Matrix>(matrix).solve(right);
  // The condition is below a thousand.
  EXPECT_LT((factors.Solve(right) - expected).norm(), 1e-12 * expected.norm());
}

TEST(SmallCholeskyTest, SolvesAsEigenDoes) {
  SolvesAsEigenDoes<1>();
  SolvesAsEigenDoes<6>();
  SolvesAsEigenDoes<15>();
  SolvesAsEigenDoes<28>();
}

TEST(SmallCholeskyTest, RefusesSmallPivots) {
  const auto takes = [](double last) {
    Eigen::Matrix2d matrix;
    matrix << 1.0, 1.0, 1.0, last;
    return SmallCholesky<2>().Compute(matrix, 1e-6);
  };
  EXPECT_TRUE(takes(1.0 + 2e-6));
  EXPECT_FALSE(takes(1.0 + 0.5e-6));
  EXPECT_FALSE(takes(1.0));
  EXPECT_FALSE(takes(0.5));
  EXPECT_FALSE(takes(std::numeric_limits<double>::quiet_NaN()));
}

}  // namespace
}  // namespace curvd::testing
