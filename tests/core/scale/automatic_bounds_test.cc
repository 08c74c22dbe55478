// What bounds an automatic estimate: the options, the size of the cloud, and memory.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/job/job_memory.h"
#include "core/scale/automatic.h"
#include "core/scale/pilot/pilot.h"
#include "tests/core/scale/automatic_requests.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

TEST(AutomaticBoundsTest, FixedEstimatesTellNothing) {
  EXPECT_FALSE(MustEstimate(Sphere(1000, 1.0).ToCloud(), {}).scale_report.has_value());
}

TEST(AutomaticBoundsTest, OneEstimatorMayBeFixedOrTheCount) {
  const TestPoints sphere = NoisySphere(5000, 0.01);
  EstimatorOptions jets = Automatic();
  jets.estimator = "jet";
  jets.jet_degree = 4;
  const EstimationResult by_jets = MustEstimate(sphere.ToCloud(), jets);
  for (const ScaleOutcome& outcome : by_jets.scale_report->outcomes) {
    EXPECT_EQ(outcome.estimator, "jet");
    EXPECT_EQ(outcome.degree, 4u);
  }
  EstimatorOptions counted = Automatic();
  counted.neighborhood = NeighborCount{100};
  const EstimationResult result = MustEstimate(sphere.ToCloud(), counted);
  for (const ScaleOutcome& outcome : result.scale_report->outcomes) EXPECT_EQ(outcome.neighbor_count, 100u);
  EstimatorOptions hexagram;
  hexagram.neighborhood = NeighborCount{100};
  const EstimationResult fixed = MustEstimate(sphere.ToCloud(), hexagram);
  EXPECT_EQ(result.field.points[17].radius, fixed.field.points[17].radius);
}

// 45 neighbors tell what 44 are worth.
TEST(AutomaticBoundsTest, BoundsBetweenTwoScalesLeaveTheEstimator) {
  const TestPoints points = Torus(2'000, 1);
  const EstimationResult result =
      MustEstimate(points.ToCloud(), WithChoice(Automatic({.least_count = 33, .most_count = 44})));
  ASSERT_TRUE(result.scale_report.has_value());
  EXPECT_FALSE(result.scale_report->outcomes.empty());
  for (size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(result.choices[i].neighbor_count, 44.0f) << i;
    ASSERT_GT(result.choices[i].mean_error, 0.0f) << i;
  }
}

TEST(AutomaticBoundsTest, NoNeighborhoodHasFewerPointsThanTheLeast) {
  const auto count_of = [](size_t points, uint32_t least, uint32_t most) {
    const EstimationResult result =
        MustEstimate(Sphere(points, 1.0).ToCloud(), WithChoice(Automatic({.least_count = least, .most_count = most})));
    const auto [fewest, largest] = std::minmax_element(
        result.choices.span().begin(), result.choices.span().end(),
        [](const PointChoice& a, const PointChoice& b) { return a.neighbor_count < b.neighbor_count; });
    EXPECT_EQ(fewest->neighbor_count, largest->neighbor_count);
    return fewest->neighbor_count;
  };
  // Nothing can be judged by neighborhoods of more than a third of a cloud.
  EXPECT_EQ(count_of(50, 18, 2048), 23.0f);
  EXPECT_EQ(count_of(1500, 750, 1100), 1024.0f);
  EXPECT_EQ(count_of(500, 300, 340), 340.0f) << "no scale lies within";
}

TEST(AutomaticBoundsTest, ACloudOfFewerPointsThanTheLeastHasNoResults) {
  const EstimationResult result = MustEstimate(Sphere(500, 1.0).ToCloud(), Automatic({.least_count = 501}));
  EXPECT_EQ(result.field.status_counts[static_cast<size_t>(PointStatus::kTooFewNeighbors)], 500u);
  EXPECT_EQ(LeastPoints(Automatic({.least_count = 501})), 501u);
}

// Whatever the fewest neighbors of a choice are.
TEST(AutomaticBoundsTest, ARadiusAsksForNoNumberOfPoints) {
  EstimatorOptions options;
  options.neighborhood = NeighborRadius{1.0};
  options.max_neighbor_count = 12;
  EXPECT_EQ(LeastPoints(options), 0u);
}

TEST(AutomaticBoundsTest, NeverLooksFartherThanItMay) {
  const TestPoints sphere = NoisySphere(10'000, 0.01);
  constexpr double kMost = 0.2;
  const EstimationResult result = MustEstimate(sphere.ToCloud(), Automatic({.max_radius = kMost}));
  EXPECT_GT(result.field.status_counts[static_cast<size_t>(PointStatus::kOk)], 9'900u);
  for (const PointCurvature& point : result.field.points.span()) {
    EXPECT_TRUE(point.status != PointStatus::kOk || point.radius <= kMost) << point.radius;
  }
  const EstimationResult none = MustEstimate(sphere.ToCloud(), Automatic({.max_radius = 1e-6}));
  EXPECT_EQ(none.field.status_counts[static_cast<size_t>(PointStatus::kTooFewNeighbors)], 10'000u);
}

TEST(AutomaticBoundsTest, SmallCloudsHaveAReasonOrNumbers) {
  for (const size_t points : {1, 4, 8, 15}) {
    const EstimationResult result = MustEstimate(Sphere(points, 1.0).ToCloud(), Automatic());
    EXPECT_EQ(result.field.status_counts[static_cast<size_t>(PointStatus::kTooFewNeighbors)], points);
  }
  for (const size_t points : {16, 17, 40, 48, 64, 100, 200}) {
    const EstimationResult result = MustEstimate(Sphere(points, 1.0).ToCloud(), Automatic());
    for (const PointCurvature& point : result.field.points.span()) {
      EXPECT_TRUE(point.status != PointStatus::kOk ||
                  std::isfinite(point.mean + point.gaussian + point.k1 + point.d1[0]));
    }
  }
}

TEST(AutomaticBoundsTest, OptionsOutOfRangeAreRefused) {
  const auto refused = [](const EstimatorOptions& options, const std::string& words) {
    const absl::Status status = options.Validate();
    return KindOf(status) == ErrorKind::kInvalid && status.message().find(words) != std::string::npos;
  };
  EXPECT_TRUE(Automatic().Validate().ok());
  EXPECT_TRUE(refused(Automatic({.least_count = 15}), "least_count is 15"));
  EXPECT_TRUE(refused(Automatic({.least_count = 65, .most_count = 64}), "least_count is 65"));
  EXPECT_TRUE(refused(Automatic({.most_count = 2049}), "most_count is 2049"));
  EXPECT_TRUE(refused(Automatic({.max_radius = -1.0}), "max_radius is -1"));
  EXPECT_TRUE(refused(Automatic({.max_radius = std::nan("")}), "max_radius is nan"));
  for (const uint32_t count : {15, 2049}) {
    EstimatorOptions counted = Automatic();
    counted.neighborhood = NeighborCount{count};
    EXPECT_TRUE(refused(counted, "neighbor_count is " + std::to_string(count))) << "what is not judged";
  }
  EstimatorOptions radius = Automatic();
  radius.neighborhood = NeighborRadius{1.0};
  EXPECT_TRUE(refused(radius, "radius"));
  EstimatorOptions hexagram = Automatic();
  hexagram.estimator = "hexagram";
  EXPECT_TRUE(refused(hexagram, "estimator is hexagram"));
  EstimatorOptions aso = Automatic();
  aso.estimator = "aso";
  EXPECT_TRUE(refused(aso, "project is false"));
  aso.project = true;
  EXPECT_TRUE(aso.Validate().ok());
  EstimatorOptions jet = Automatic();
  jet.estimator = "jet";
  EXPECT_TRUE(refused(jet, "jet_degree is 2"));
}

// As the job runs it, on one scratch. Returns how many points were sampled.
uint32_t ExpectMemoryWithinItsBounds(const SpatialIndex& index, uint32_t most_count, const std::string& what) {
  const EstimatorOptions options = WithChoice(Automatic({.most_count = most_count}));
  std::vector<PointCurvature> results(index.point_count());
  std::vector<PointChoice> choices(index.point_count());
  const Strategy& strategy = StrategyFor(options);
  const auto run = strategy.start(options, index, results.data());
  run->WriteChoicesTo(choices.data());
  const auto scratch = run->MakeScratch();
  const size_t most_shared =
      strategy.shared_bytes(options, index.point_count()) + strategy.bytes_per_point * index.point_count();
  for (const GroupPhase& phase : run->Phases()) {
    const absl::StatusOr<bool> is_needed = phase.Begin();
    EXPECT_TRUE(is_needed.ok()) << is_needed.status();
    EXPECT_LE(run->bytes(), most_shared) << what;
    if (!is_needed.value_or(false)) continue;
    for (size_t group = 0; group < index.group_count(); ++group) {
      EXPECT_TRUE(phase.run(group, *scratch).ok());
      EXPECT_LE(scratch->bytes(), strategy.scratch_bytes(options, index.point_count())) << what;
    }
  }
  return run->scale_report()->sampled_points;
}

TEST(AutomaticBoundsTest, ScratchNeverHoldsMoreThanItsBound) {
  for (const uint32_t most : {16u, 128u, 2048u}) {
    for (const Layout layout : kLayouts) {
      ExpectMemoryWithinItsBounds(BuildIndex(RandomPoints(layout, 3000, 5).ToCloud()), most, LayoutName(layout));
    }
    ExpectMemoryWithinItsBounds(BuildIndex(HalfNoisySphere(3000).ToCloud()), most, "half noisy");
  }
  const SpatialIndex large = BuildIndex(HalfNoisySphere(20'000).ToCloud());
  EXPECT_GT(ExpectMemoryWithinItsBounds(large, 512, "half noisy, with points between"), Pilot::kMostPoints);
}

TEST(AutomaticBoundsTest, WhatWorkersShareIsReservedOnce) {
  constexpr size_t kPoints = 1'000'000;
  const auto reserved = [](int threads) { return EstimationScratchBytes(Automatic(), kPoints, threads); };
  const Strategy& strategy = StrategyFor(Automatic());
  const size_t of_worker = strategy.scratch_bytes(Automatic(), kPoints);
  EXPECT_EQ(reserved(1), strategy.shared_bytes(Automatic(), kPoints) + of_worker);
  EXPECT_EQ(reserved(8), reserved(1) + 7 * of_worker);
}

}  // namespace
}  // namespace curvd::testing
