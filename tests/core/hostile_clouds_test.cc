// Every estimator on clouds that are made to cost too much: whatever it says of a point is a number, or why there is
// none.
#include "tests/core/hostile_clouds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>

#include "core/estimators/strategies.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

bool IsFinite(const PointCurvature& point) {
  return std::isfinite(point.mean) && std::isfinite(point.gaussian) && std::isfinite(point.k1) &&
         std::isfinite(point.k2) && point.k1 <= point.k2 && point.radius > 0.0f;
}

class HostileCloudTest : public ::testing::TestWithParam<HostileCloud> {};

TEST_P(HostileCloudTest, EveryEstimatorGivesNumbersOrAReason) {
  constexpr size_t kPoints = 3000;
  TestPoints points;
  GetParam().make(kPoints, points.positions, points.normals);
  ASSERT_EQ(points.size(), kPoints);
  for (const Strategy* strategy : Strategies()) {
    EstimatorOptions options;
    options.estimator = strategy->name;
    const EstimationResult one = MustEstimate(points.ToCloud(), options, 1);
    const EstimationResult two = MustEstimate(points.ToCloud(), options, 2);
    ASSERT_EQ(one.field.points.size(), kPoints) << strategy->name;
    for (size_t i = 0; i < kPoints; ++i) {
      const PointCurvature& point = one.field.points[i];
      ASSERT_LT(static_cast<int>(point.status), kPointStatusEnd) << strategy->name << " point " << i;
      ASSERT_TRUE(point.status != PointStatus::kOk || IsFinite(point)) << strategy->name << " point " << i;
    }
    ASSERT_EQ(FirstDifference(one.field.points.span(), two.field.points.span()), kPoints)
        << strategy->name << " on two threads";
  }
}

INSTANTIATE_TEST_SUITE_P(EachCloud, HostileCloudTest,
                         ::testing::ValuesIn(HostileClouds().begin(), HostileClouds().end()),
                         [](const auto& info) { return IdentifierOf(info.param); });

}  // namespace
}  // namespace curvd::testing
