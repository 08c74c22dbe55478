#include "core/scale/scale_report.h"

#include <gtest/gtest.h>

namespace curvd::testing {
namespace {

ScaleOutcome Outcome(std::string_view estimator, uint32_t count, double error, double share) {
  return {estimator, count, error, 0.5 * error, 0.25 * error, share};
}

TEST(ScaleReportTest, OfTwoDegreesOfJetsTheBetterOneStandsWithTheShareOfBoth) {
  for (const bool better_comes_first : {false, true}) {
    ScaleReport report;
    const ScaleOutcome worse = Outcome("jet", 64, 0.4, 0.125), better = Outcome("jet", 64, 0.2, 0.5);
    report.Add(better_comes_first ? better : worse);
    report.Add(better_comes_first ? worse : better);
    ASSERT_EQ(report.outcomes.size(), 1u);
    EXPECT_EQ(report.outcomes[0].error, 0.2);
    EXPECT_EQ(report.outcomes[0].noise, 0.1);
    EXPECT_EQ(report.outcomes[0].bias, 0.05);
    EXPECT_EQ(report.outcomes[0].share, 0.625);
  }
}

TEST(ScaleReportTest, OtherEstimatorsAndCountsStandApartInTheirOrder) {
  ScaleReport report;
  report.Add(Outcome("jet", 64, 0.4, 0.25));
  report.Add(Outcome("jet", 91, 0.3, 0.25));
  report.Add(Outcome("aso", 64, 0.2, 0.25));
  ASSERT_EQ(report.outcomes.size(), 3u);
  EXPECT_EQ(report.outcomes[1].neighbor_count, 91u);
  EXPECT_EQ(report.outcomes[2].estimator, "aso");
  EXPECT_EQ(report.outcomes[2].share, 0.25);
}

TEST(ScaleReportTest, PartsOfACloudCountByTheirSamples) {
  ScaleReport first, second, both;
  first.Add(Outcome("jet", 16, 0.1, 1.0));
  first.Add(Outcome("jet", 64, 1e-6, 0.0));
  first.sigma = 0.01;
  first.normal_sigma = 0.2;
  second.Add(Outcome("jet", 32, 0.3, 0.25));
  second.Add(Outcome("jet", 64, 0.2, 0.75));
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

}  // namespace
}  // namespace curvd::testing
