#include "core/scale/scale_report.h"

#include <gtest/gtest.h>

namespace curvd::testing {
namespace {

ScaleOutcome Jet(uint32_t degree, uint32_t count, double error, double share) {
  return {"jet", degree, count, error, 0.5 * error, 0.25 * error, share};
}

TEST(ScaleReportTest, PartsOfACloudCountByTheirSamples) {
  ScaleReport first, second, both;
  first.outcomes = {Jet(4, 16, 0.1, 1.0), Jet(4, 64, 1e-6, 0.0)};
  first.sigma = 0.01;
  first.normal_sigma = 0.2;
  second.outcomes = {Jet(4, 32, 0.3, 0.25), Jet(4, 64, 0.2, 0.75)};
  second.sigma = 0.02;
  first.sampled_points = 100;
  second.sampled_points = 300;
  both.AddPart(first, 0.25);
  both.AddPart(second, 0.75);
  ASSERT_EQ(both.outcomes.size(), 3u);
  EXPECT_EQ(both.outcomes[0].share, 0.25);
  EXPECT_EQ(both.outcomes[1].neighbor_count, 32u);
  EXPECT_EQ(both.outcomes[1].share, 0.1875);
  EXPECT_EQ(both.outcomes[2].error, 0.2) << "of the part in which it counts";
  EXPECT_EQ(both.outcomes[2].share, 0.5625);
  EXPECT_EQ(both.sampled_points, 400u);
  EXPECT_EQ(both.sigma, 0.02);
  EXPECT_EQ(both.normal_sigma, 0.2);
}

TEST(ScaleReportTest, DegreesAndEstimatorsOfTwoPartsStandApart) {
  ScaleReport first, second, both;
  first.outcomes = {Jet(4, 64, 0.1, 0.5), Jet(2, 64, 0.2, 0.5)};
  second.outcomes = {Jet(2, 64, 0.3, 0.75), {"aso", 0, 64, 0.1, 0.05, 0.0, 0.25}};
  both.AddPart(first, 0.5);
  both.AddPart(second, 0.5);
  ASSERT_EQ(both.outcomes.size(), 3u);
  EXPECT_EQ(both.outcomes[0].degree, 4u);
  EXPECT_EQ(both.outcomes[0].share, 0.25);
  EXPECT_EQ(both.outcomes[1].degree, 2u);
  EXPECT_EQ(both.outcomes[1].error, 0.3) << "of the part in which it counts";
  EXPECT_EQ(both.outcomes[1].share, 0.625);
  EXPECT_EQ(both.outcomes[2].estimator, "aso");
}

}  // namespace
}  // namespace curvd::testing
