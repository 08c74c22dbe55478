#include "core/base/quantile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace curvd {
namespace {

TEST(QuantileTest, IsTheValueAtThePlaceRoundedDown) {
  const std::vector<double> values = {7.0, 3.0, 9.0, 1.0, 5.0};
  for (const auto& [share, expected] :
       std::vector<std::pair<double, double>>{{0.0, 1.0}, {0.19, 1.0}, {0.5, 5.0}, {0.79, 7.0}, {0.9, 9.0}}) {
    std::vector<double> reordered = values;
    EXPECT_EQ(Quantile(reordered, share), expected) << share;
  }
}

TEST(QuantileTest, OfAnEvenNumberTheHalfIsTheLargerOfTheMiddleTwo) {
  std::vector<double> values = {4.0, 1.0, 3.0, 2.0};
  EXPECT_EQ(Quantile(values, 0.5), 3.0);
}

TEST(QuantileTest, OfOneValueIsThatValue) {
  std::vector<double> values = {2.0};
  EXPECT_EQ(Quantile(values, 0.0), 2.0);
  EXPECT_EQ(Quantile(values, 0.99), 2.0);
}

TEST(QuantileTest, KeepsAllValues) {
  std::vector<double> values = {2.0, 2.0, 1.0, 3.0, 2.0};
  EXPECT_EQ(Quantile(values, 0.5), 2.0);
  std::sort(values.begin(), values.end());
  EXPECT_EQ(values, (std::vector<double>{1.0, 2.0, 2.0, 2.0, 3.0}));
}

TEST(LowerQuantileTest, IsTheValueAtThePlaceAmongOneLess) {
  const std::vector<double> values = {7.0, 3.0, 9.0, 1.0, 5.0};
  for (const auto& [share, expected] :
       std::vector<std::pair<double, double>>{{0.0, 1.0}, {0.24, 1.0}, {0.25, 3.0}, {0.5, 5.0}, {0.99, 7.0}}) {
    EXPECT_EQ(LowerQuantile(values, share), expected) << share;
  }
  EXPECT_EQ(values.front(), 7.0) << "the values stay as they are";
}

}  // namespace
}  // namespace curvd
