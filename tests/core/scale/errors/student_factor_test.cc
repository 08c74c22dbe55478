#include "core/scale/errors/student_factor.h"

#include <gtest/gtest.h>

#include <utility>

namespace curvd {
namespace {

TEST(StudentFactorTest, IsTheQuantileOverThatOfTheGaussianDistribution) {
  // 95 % quantiles of Student's distribution, by degrees of freedom.
  for (const auto& [samples, quantile] :
       {std::pair{2.0, 2.920}, {3.0, 2.353}, {5.0, 2.015}, {12.0, 1.782}, {120.0, 1.658}}) {
    EXPECT_NEAR(StudentFactor(samples) * 1.645 / quantile, 1.0, 0.0125) << samples;
  }
}

}  // namespace
}  // namespace curvd
