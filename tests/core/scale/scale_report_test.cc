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

}  // namespace
}  // namespace curvd::testing
