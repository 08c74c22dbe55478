#include "client/surfaces/noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "client/surfaces/random.h"

namespace curv {
namespace {

TEST(CounterRandomTest, IsAFunctionOfItsArguments) {
  EXPECT_EQ(CounterRandom(1, 2).Bits(3), CounterRandom(1, 2).Bits(3));
  EXPECT_NE(CounterRandom(1, 2).Bits(3), CounterRandom(2, 2).Bits(3));
  EXPECT_NE(CounterRandom(1, 2).Bits(3), CounterRandom(1, 3).Bits(3));
  EXPECT_NE(CounterRandom(1, 2).Bits(3), CounterRandom(1, 2).Bits(4));
}

TEST(CounterRandomTest, DrawsFromItsDistributions) {
  const CounterRandom random(0, 0);
  constexpr int kDraws = 100'000;
  double uniform = 0, gaussian = 0, squares = 0, fourth = 0;
  for (uint64_t i = 0; i < kDraws; ++i) {
    ASSERT_GE(random.Uniform(i), 0.0);
    ASSERT_LT(random.Uniform(i), 1.0);
    const double g = random.Gaussian(i);
    uniform += random.Uniform(i);
    gaussian += g;
    squares += g * g;
    fourth += g * g * g * g;
  }
  // Five standard deviations of each mean.
  EXPECT_NEAR(uniform / kDraws, 0.5, 5 * 0.289 / std::sqrt(kDraws));
  EXPECT_NEAR(gaussian / kDraws, 0.0, 5 / std::sqrt(kDraws));
  EXPECT_NEAR(squares / kDraws, 1.0, 5 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(fourth / kDraws, 3.0, 5 * std::sqrt(96.0 / kDraws));
}

TEST(NoiseTest, MovesPositionsByItsSigma) {
  std::vector<Vec3> positions(50'000, {1, 2, 3});
  AddPositionNoise(0.1, 4, positions);
  double squares = 0;
  for (const Vec3& p : positions) squares += Dot(p - Vec3{1, 2, 3}, p - Vec3{1, 2, 3});
  EXPECT_NEAR(std::sqrt(squares / 150'000), 0.1, 0.001);
}

TEST(NoiseTest, KeepsNormalsUnit) {
  std::vector<Vec3> normals(1000, {0, 0, 1});
  AddNormalNoise(0.2, 4, normals);
  double sideways = 0;
  for (const Vec3& n : normals) {
    EXPECT_NEAR(Norm(n), 1.0, 1e-15);
    sideways += std::hypot(n.x, n.y);
  }
  EXPECT_NEAR(sideways / 1000, 0.2 * std::sqrt(M_PI / 2), 0.02);
}

TEST(NoiseTest, NoSigmaChangesNothing) {
  std::vector<Vec3> positions = {{1, 2, 3}};
  AddPositionNoise(0.0, 4, positions);
  EXPECT_EQ(positions[0], (Vec3{1, 2, 3}));
}

}  // namespace
}  // namespace curv
