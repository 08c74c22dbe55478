#include "core/base/order_statistic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace curvd::testing {
namespace {

void ExpectAllAsSorted(const std::vector<double>& values) {
  std::vector<double> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  for (size_t place = 0; place < values.size(); ++place) {
    std::vector<double> overwritten = values;
    EXPECT_EQ(OrderStatistic(overwritten, place), sorted[place]) << place << " of " << values.size();
  }
}

TEST(OrderStatisticTest, IsThatOfSortedValues) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (const size_t size : {1, 2, 3, 15, 16, 17, 18, 100, 513}) {
    std::vector<double> values(size), few(size), rising(size), falling(size);
    for (size_t i = 0; i < size; ++i) {
      values[i] = std::exp(5.0 * normal(random));
      few[i] = std::floor(2.0 * normal(random));
      rising[i] = static_cast<double>(i);
      falling[i] = -rising[i];
    }
    for (const auto& all : {values, few, rising, falling, std::vector<double>(size, 3.0)}) ExpectAllAsSorted(all);
  }
}

TEST(OrderStatisticTest, TakesInfinitiesAndZeros) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<double> values(40, 0.0);
  for (size_t i = 0; i < 10; ++i) {
    values[4 * i] = -kInfinity;
    values[4 * i + 1] = kInfinity;
    values[4 * i + 2] = -0.0;
  }
  ExpectAllAsSorted(values);
}

// Pivots that each leave all values but one or two: the rounds are counted.
TEST(OrderStatisticTest, BadPivotsEndInTheSameValue) {
  std::vector<double> values(400);
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(std::min(i, values.size() - i));
  ExpectAllAsSorted(values);
}

}  // namespace
}  // namespace curvd::testing
