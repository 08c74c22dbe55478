#include "core/job/job_memory.h"

#include <gtest/gtest.h>

#include "core/estimators/options.h"

namespace curvd::testing {
namespace {

size_t BytesPerPoint(EstimatorOptions options, bool returns_choice) {
  options.returns_choice = returns_choice;
  return EstimationBytesPerPoint(options, {});
}

// docs/operations.md tells operators these numbers.
TEST(JobMemoryTest, ReservesForAPointWhatItsEstimateHoldsAtATime) {
  const EstimatorOptions fixed{.estimator = "avg-hexagram", .neighborhood = NeighborCount{64}};
  EXPECT_EQ(BytesPerPoint(fixed, false), 96u);
  EXPECT_EQ(BytesPerPoint(fixed, true), 140u) << "with normals of halves and choices";
  const EstimatorOptions automatic{.estimator = kAutomaticEstimator, .neighborhood = AutomaticScale{}};
  EXPECT_EQ(BytesPerPoint(automatic, false), 125u) << "with normals of halves, then what looks for outliers";
  EXPECT_EQ(BytesPerPoint(automatic, true), 157u);
  const EstimatorOptions scale{.estimator = "avg-hexagram", .neighborhood = AutomaticScale{}};
  EXPECT_EQ(BytesPerPoint(scale, false), 108u) << "neither marks of edges nor outliers";
  const EstimatorOptions jets{.estimator = "jet", .neighborhood = AutomaticScale{}, .jet_degree = 4};
  EXPECT_EQ(BytesPerPoint(jets, false), 96u) << "without normals of halves";
}

}  // namespace
}  // namespace curvd::testing
