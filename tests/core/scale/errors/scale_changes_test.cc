#include "core/scale/errors/scale_changes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace curvd::testing {
namespace {

// What is told of errors of standard deviation 1 at the first scale, as `errors` makes those of three scales, over the
// true one.
template <typename Errors>
double Told(size_t method, const Errors& errors) {
  constexpr int kTrials = 20'000;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  ScaleChanges changes(method);
  double squares = 0.0;
  for (int i = 0; i < kTrials; ++i) {
    double e[3];
    errors([&] { return normal(random); }, e);
    changes.Add(e[0] - e[1], e[1] - e[2]);
    squares += (e[0] - e[1]) * (e[0] - e[1]);
  }
  return changes.ErrorPerChange() * std::sqrt(squares / kTrials);
}

TEST(ScaleChangesTest, TheoryOfEachMethod) {
  for (const size_t method : {kHexagramMethod, kRegressionMethod, kQuarticMethod, kQuadricMethod}) {
    EXPECT_DOUBLE_EQ(BiasGrowth(method), 2.0);
  }
  EXPECT_DOUBLE_EQ(BiasGrowth(kSexticMethod), std::sqrt(8.0)) << "the radius to the sixth, by the fourth root of 2";
  EXPECT_DOUBLE_EQ(VarianceLeft(kHexagramMethod), 0.25) << "twice the count, by the square";
  EXPECT_DOUBLE_EQ(VarianceLeft(kRegressionMethod), 0.5);
  EXPECT_DOUBLE_EQ(VarianceLeft(kQuadricMethod), 0.125) << "twice the count, by the cube";
  EXPECT_DOUBLE_EQ(VarianceLeft(kQuarticMethod), std::sqrt(0.125));
}

// 20,000 trials tell a standard deviation to half a percent.
TEST(ScaleChangesTest, ABiasThatGrowsAsTheOrderSays) {
  for (size_t method = 0; method < kMethodCount; ++method) {
    const double growth = BiasGrowth(method);
    EXPECT_NEAR(Told(method,
                     [&](const auto& normal, double* e) {
                       e[0] = normal();
                       e[1] = growth * e[0];
                       e[2] = growth * e[1];
                     }),
                1.0, 0.02)
        << method;
  }
}

TEST(ScaleChangesTest, NoiseOfNestedAverages) {
  for (size_t method = 0; method < kMethodCount; ++method) {
    const double left = VarianceLeft(method);
    EXPECT_NEAR(Told(method,
                     [&](const auto& normal, double* e) {
                       e[2] = left * normal();
                       e[1] = e[2] + std::sqrt(left - left * left) * normal();
                       e[0] = e[1] + std::sqrt(1.0 - left) * normal();
                     }),
                1.0, 0.05)
        << method;
  }
}

// As of fits of hardly more neighbors than coefficients, whose bias depends on where each of those lies.
TEST(ScaleChangesTest, BiasesThatGrowAndHaveLittleInCommon) {
  for (const double correlation : {0.0, 0.4, 0.8}) {
    const double rest = std::sqrt(1.0 - correlation * correlation);
    EXPECT_NEAR(Told(kSexticMethod,
                     [&](const auto& normal, double* e) {
                       double unit = e[0] = normal();
                       for (int k = 1; k < 3; ++k) {
                         unit = correlation * unit + rest * normal();
                         e[k] = std::pow(2.4, k) * unit;
                       }
                     }),
                1.0, 0.05)
        << correlation;
  }
}

// Even growth alone has no limit where noise that falls and a bias that grows come to the same.
TEST(ScaleChangesTest, NoiseBesideABiasIsNotToldManyTimesTooLarge) {
  constexpr size_t kMethod = kRegressionMethod;
  const double noise = std::sqrt(0.8), bias = std::sqrt(0.2), left = VarianceLeft(kMethod);
  const double told = Told(kMethod, [&](const auto& normal, double* e) {
    double error = bias * normal();
    const double last = noise * left * normal(), middle = last + noise * std::sqrt(left - left * left) * normal();
    e[0] = error + middle + noise * std::sqrt(1.0 - left) * normal();
    e[1] = BiasGrowth(kMethod) * error + middle;
    e[2] = BiasGrowth(kMethod) * BiasGrowth(kMethod) * error + last;
  });
  EXPECT_NEAR(told, 1.0, 0.1);
}

TEST(ScaleChangesTest, WhatNeverChangesHasNoLimitOfItsOwn) {
  ScaleChanges changes(kRegressionMethod);
  EXPECT_EQ(changes.ErrorPerChange(), 1.0);
  changes.Add(0.0, 0.0);
  EXPECT_EQ(changes.ErrorPerChange(), 1.0);
  changes.Add(1.0, 1.0);  // a slope without end: even growth has no answer
  EXPECT_TRUE(std::isfinite(changes.ErrorPerChange()));
}

TEST(ScaleChangesTest, TheUnitDoesNotMatter) {
  ScaleChanges small(kQuarticMethod), large(kQuarticMethod);
  for (const auto& [first, second] : {std::pair{1.0, 1.5}, {-2.0, -1.0}, {0.5, 2.0}}) {
    small.Add(0x1p-40 * first, 0x1p-40 * second);
    large.Add(0x1p40 * first, 0x1p40 * second);
  }
  EXPECT_EQ(small.ErrorPerChange(), large.ErrorPerChange());
}

}  // namespace
}  // namespace curvd::testing
