// Estimates at several scales with one search, beside estimates at each scale alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "core/estimators/strategies.h"
#include "core/job/estimation_job.h"
#include "core/job/job_memory.h"
#include "tests/core/instruction_sets.h"
#include "tests/core/seam_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

using ::testing::HasSubstr;

using ScalesTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, ScalesTest, InstructionSets(), InstructionSetName);

// Counts in descending order.
EstimatorOptions Options(std::string_view estimator, const std::vector<uint32_t>& counts) {
  EstimatorOptions options;
  options.estimator = estimator;
  options.neighborhood = NeighborCount{counts.front()};
  options.smaller_counts.size = counts.size() - 1;
  std::copy(counts.begin() + 1, counts.end(), options.smaller_counts.counts.begin());
  return options;
}

std::span<const PointCurvature> AtScale(const EstimationResult& result, size_t scale) {
  return scale == 0 ? result.field.points.span() : result.smaller[scale - 1].span();
}

// Every scale has the bytes of an estimate at that scale alone, and the counts are the sums of theirs.
void ExpectSameAsAlone(const TestPoints& points, const EstimatorOptions& options, const std::string& what,
                       const NormalOptions& normals = {}) {
  WorkerPool pool(2);
  const auto result = EstimateCurvature(points.ToCloud(), options, normals, pool);
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_EQ(result->smaller.size(), options.smaller_counts.size);
  std::array<uint64_t, kPointStatusEnd> counts{};
  for (size_t scale = 0; scale < options.scale_count(); ++scale) {
    const auto alone = EstimateCurvature(points.ToCloud(), options.AtScale(scale), normals, pool);
    ASSERT_TRUE(alone.ok()) << alone.status();
    ASSERT_EQ(AtScale(*result, scale).size(), points.size());
    EXPECT_EQ(FirstDifference(AtScale(*result, scale), alone->field.points.span()), points.size())
        << what << ", " << options.estimator << ", scale " << scale;
    for (int status = 0; status < kPointStatusEnd; ++status) counts[status] += alone->field.status_counts[status];
  }
  EXPECT_EQ(result->field.status_counts, counts) << what << ", " << options.estimator;
}

constexpr std::string_view kEstimatorsOfScales[] = {"avg-hexagram", "normal-regression"};

TEST_P(ScalesTest, HaveTheBytesOfEachScaleAlone) {
  for (const std::string_view estimator : kEstimatorsOfScales) {
    ExpectSameAsAlone(Waves(1500, 0.01, 1), Options(estimator, {1000, 300, 299, 50, 16, 5, 4}), "waves");
    ExpectSameAsAlone(Sphere(700, 3.0), Options(estimator, {64, 32, 16}), "sphere");
  }
}

TEST_P(ScalesTest, HaveThemWithEachDegreeOfRegressions) {
  for (uint32_t degree = kMinRegressionDegree; degree <= kMaxRegressionDegree; ++degree) {
    EstimatorOptions options = Options("normal-regression", {400, 128, 40, 6});
    options.regression_degree = degree;
    ExpectSameAsAlone(Waves(900, 0.01, 1), options, std::to_string(degree));
  }
}

TEST_P(ScalesTest, HaveThemInEveryLayout) {
  for (const std::string_view estimator : kEstimatorsOfScales) {
    for (const Layout layout : kLayouts) {
      ExpectSameAsAlone(RandomPoints(layout, 600, 2), Options(estimator, {300, 100, 20, 4}), LayoutName(layout));
    }
  }
}

TEST_P(ScalesTest, HaveThemWithEachNumberOfRotations) {
  for (uint32_t rotations = 1; rotations <= kMaxRotations; ++rotations) {
    EstimatorOptions options = Options("avg-hexagram", {128, 40});
    options.rotation_count = rotations;
    ExpectSameAsAlone(Waves(500, 0.0, 1), options, std::to_string(rotations));
  }
}

TEST(ScalesJobTest, ALargeScaleMayHaveTooFewPointsWhereASmallOneHasNot) {
  for (const std::string_view estimator : kEstimatorsOfScales) {
    const EstimatorOptions options = Options(estimator, {300, 200, 50, 20});
    ExpectSameAsAlone(Sphere(100, 1.0), options, "two scales fit");
    ExpectSameAsAlone(Sphere(30, 1.0), options, "one scale fits");
    ExpectSameAsAlone(Sphere(10, 1.0), options, "none fits");
    const EstimationResult result = MustEstimate(Sphere(100, 1.0).ToCloud(), options);
    EXPECT_EQ(result.field.points[0].status, PointStatus::kTooFewNeighbors);
    EXPECT_EQ(result.smaller[1][0].status, PointStatus::kOk);
  }
}

TEST(ScalesJobTest, HaveTheSeamsOfEachScaleAlone) {
  TestPoints half = Sphere(2000, 1.0), some = half;
  FlipWhere([](const std::array<float, 3>& p) { return p[2] > 0.0f; }, half);
  FlipAtRandom(0.01, 1, some);
  for (const std::string_view estimator : kEstimatorsOfScales) {
    ExpectSameAsAlone(half, Options(estimator, {200, 60, 15}), "half of a sphere is flipped");
    ExpectSameAsAlone(some, Options(estimator, {200, 60, 15}), "some normals are flipped");
  }
}

TEST(ScalesJobTest, PointsThatAreNotFiniteAndHaveNoNormalAreSoAtEveryScale) {
  TestPoints points = Waves(800, 0.0, 3);
  points.positions[7][1] = std::numeric_limits<float>::quiet_NaN();
  points.positions[500] = {100.0f, 100.0f, 100.0f};
  NormalOptions normals;
  normals.source = NormalSource::kEstimate;
  for (const std::string_view estimator : kEstimatorsOfScales) {
    ExpectSameAsAlone(points, Options(estimator, {64, 16}), "invalid");
    ExpectSameAsAlone(points, Options(estimator, {64, 16}), "estimated normals", normals);
  }
}

TEST(ScalesJobTest, TakeTheMemoryThatIsReservedForThem) {
  for (const std::string_view estimator : kEstimatorsOfScales) {
    const EstimatorOptions options = Options(estimator, {512, 128, 32});
    const TestPoints points = Waves(20'000, 0.01, 1);
    const EstimationResult result = MustEstimate(points.ToCloud(), options, 1);
    const size_t reserved =
        points.size() * EstimationBytesPerPoint(options) + EstimationScratchBytes(options, points.size(), 1);
    EXPECT_LE(result.cost.peak_bytes, reserved) << estimator;
    EXPECT_GE(EstimationBytesPerPoint(options),
              EstimationBytesPerPoint(options.AtScale(0)) + 2 * sizeof(PointCurvature));
  }
}

std::string ErrorOf(const EstimatorOptions& options) { return std::string(options.Validate().message()); }

TEST(ScalesJobTest, RefusesWhatItCannotServe) {
  EXPECT_EQ(ErrorOf(Options("avg-hexagram", {64, 32, 16})), "");
  EXPECT_THAT(
      ErrorOf(Options("jet", {64, 32})),
      HasSubstr("estimator is jet; it must be one of avg-hexagram, normal-regression with several neighbor counts"));
  EXPECT_THAT(ErrorOf(Options("auto", {64, 32})), HasSubstr("estimator is auto"));
  EXPECT_THAT(ErrorOf(Options("avg-hexagram", {64, 64})), HasSubstr("is 64; it must be from 4 to 63"));
  EXPECT_THAT(ErrorOf(Options("avg-hexagram", {64, 3})), HasSubstr("is 3; it must be from 4 to 63"));
  EstimatorOptions radius = Options("avg-hexagram", {64, 32});
  radius.neighborhood = NeighborRadius{1.0};
  EXPECT_THAT(ErrorOf(radius), HasSubstr("unless the neighborhood is a neighbor_count"));
}

}  // namespace
}  // namespace curvd::testing
