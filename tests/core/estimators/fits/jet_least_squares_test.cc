#include "core/estimators/fits/jet_least_squares.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "core/estimators/triangles/random_stream.h"

namespace curvd {
namespace {

// Neighbors as the search leaves them, the frame that of the coordinates.
class JetLeastSquaresTest : public ::testing::Test {
 protected:
  void SetUp() override {
    constexpr double kX[3] = {1, 0, 0}, kY[3] = {0, 1, 0}, kZ[3] = {0, 0, 1};
    jets_->u.Set(kPoint, kX);
    jets_->v.Set(kPoint, kY);
    jets_->axis.Set(kPoint, kZ);
  }

  void Add(double x, double y, double z) {
    neighbors_.Reserve(neighbors_.count + 1);
    neighbors_.dx[neighbors_.count] = static_cast<float>(x);
    neighbors_.dy[neighbors_.count] = static_cast<float>(y);
    neighbors_.dz[neighbors_.count++] = static_cast<float>(z);
  }

  double Draw() { return static_cast<double>(random_.Next() >> 11) * 0x1p-52 - 1.0; }

  static constexpr size_t kPoint = 5;
  NeighborArrays neighbors_;
  ScratchArray<double> room_;
  std::unique_ptr<JetSystems> jets_ = std::make_unique<JetSystems>();
  RandomStream random_{1, 2};
};

TEST_F(JetLeastSquaresTest, FindsThePolynomialThatPointsLieOn) {
  for (const int degree : {2, 3, 4}) {
    neighbors_.count = 0;
    for (int j = 0; j < 40; ++j) {
      // Sums of few halves are exact floats: so are the heights.
      const double x = std::round(8 * Draw()) / 8, y = std::round(8 * Draw()) / 8;
      double z = 0.0;
      for (int a = 0; a <= degree; ++a) {
        for (int b = 0; a + b <= degree; ++b) z += (a - 2 * b + 1) * std::pow(x, a) * std::pow(y, b);
      }
      Add(x, y, z);
    }
    ASSERT_TRUE(SolveJetByQr(neighbors_, kPoint, 0.5, degree, room_, *jets_));
    for (int a = 0; a <= degree; ++a) {
      for (int b = 0; a + b <= degree; ++b) {
        // In units of 2: heights halve, x and y double.
        const double expected = (a - 2 * b + 1) * std::pow(2.0, a + b - 1);
        EXPECT_NEAR(jets_->coefficients[JetIndex(a, b)][kPoint], expected, 1e-12) << a << " " << b;
      }
    }
  }
}

TEST_F(JetLeastSquaresTest, ResidualsAreNormalToTheMonomials) {
  for (int j = 0; j < 20; ++j) Add(Draw(), 0.01 * Draw(), Draw());  // narrow: the normal equations would lose digits
  ASSERT_TRUE(SolveJetByQr(neighbors_, kPoint, 1.0, 2, room_, *jets_));
  double products[6] = {};
  for (size_t j = 0; j < neighbors_.count; ++j) {
    const double x = neighbors_.dx[j], y = neighbors_.dy[j];
    const double monomials[6] = {1.0, x, y, x * x, x * y, y * y};
    double residual = neighbors_.dz[j];
    for (int c = 0; c < 6; ++c) residual -= jets_->coefficients[c][kPoint] * monomials[c];
    for (int c = 0; c < 6; ++c) products[c] += residual * monomials[c];
  }
  for (const double product : products) EXPECT_NEAR(product, 0.0, 1e-11);
}

TEST_F(JetLeastSquaresTest, WorksInItsRoomAlone) {
  for (const int degree : {2, 4}) {
    for (int j = 0; j < 1'000; ++j) Add(Draw(), Draw(), Draw());
    room_.Reserve(neighbors_.count * static_cast<size_t>(JetSize(degree) + 2));
    const size_t bytes = room_.bytes();
    room_[0] = room_[bytes / sizeof(double) - 1] = 77.0;
    ASSERT_TRUE(SolveJetByQr(neighbors_, kPoint, 1.0, degree, room_, *jets_));
    EXPECT_EQ(room_.bytes(), bytes);
    EXPECT_NE(room_[0], 77.0);
    EXPECT_LE(bytes, JetQrBytes(neighbors_.count, degree));
  }
}

TEST_F(JetLeastSquaresTest, RefusesWhatIsSingular) {
  for (int j = 0; j < 50; ++j) Add(std::cos(j), std::sin(j), Draw());  // on a circle: x^2 + y^2 = 1
  EXPECT_FALSE(SolveJetByQr(neighbors_, kPoint, 1.0, 2, room_, *jets_));
  EXPECT_FALSE(SolveJetByQr(neighbors_, kPoint, 1.0, 4, room_, *jets_));
  Add(0.5, 0.25, 0.0);  // one point inside makes the conic unique, not the quartic
  EXPECT_TRUE(SolveJetByQr(neighbors_, kPoint, 1.0, 2, room_, *jets_));
  EXPECT_FALSE(SolveJetByQr(neighbors_, kPoint, 1.0, 4, room_, *jets_));
}

}  // namespace
}  // namespace curvd
