// Estimates from normals that were made of the positions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/job/estimation_job.h"
#include "core/job/normals_job.h"
#include "tests/core/normals/normal_clouds.h"
#include "tests/core/sanitized.h"
#include "tests/core/scale/automatic_requests.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

EstimationResult EstimateFromPositions(const TestPoints& points, const EstimatorOptions& options,
                                       const NormalOptions& normals) {
  WorkerPool pool(2);
  absl::StatusOr<EstimationResult> result = EstimateCurvature(BareCloud(points), options, normals, pool);
  if (!result.ok()) {
    ADD_FAILURE() << result.status();
    return {};
  }
  return *std::move(result);
}

// A bump over an exact grid, whose rows are lines and whose border has neighbors on few of them.
TestPoints BumpOverGrid(int side) {
  TestPoints grid;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const double x = 2.0 * i / side - 1.0, y = 2.0 * j / side - 1.0;
      grid.Add(x, y, 0.2 * std::exp(-5.0 * (x * x + y * y)), 0.0, 0.0, 1.0);
    }
  }
  return grid;
}

TEST(MadeNormalsTest, TheBorderOfAGridHasNormalsOfALowerDegree) {
  const TestPoints grid = BumpOverGrid(40);
  NormalOptions quartic = EstimateBy(NormalMethod::kJet4, 24);
  quartic.sides = SidesAlongDirection{{0.0, 0.0, 1.0}};
  NormalOptions quadric = EstimateBy(NormalMethod::kJet2, 24);
  quadric.sides = quartic.sides;
  const NormalResult high = MustMakeNormals(BareCloud(grid), quartic), low = MustMakeNormals(BareCloud(grid), quadric);
  ASSERT_EQ(high.report.status_counts[static_cast<size_t>(PointStatus::kOk)], grid.size());
  size_t higher = 0;
  for (size_t i = 0; i < grid.size(); ++i) {
    const double x = grid.positions[i][0], y = grid.positions[i][1], z = grid.positions[i][2];
    const double slope[2] = {-10.0 * x * z, -10.0 * y * z};
    const double length = std::sqrt(1.0 + slope[0] * slope[0] + slope[1] * slope[1]);
    const auto error = [&](const PointNormal& normal) {
      return std::hypot(normal.normal[0] + slope[0] / length, normal.normal[1] + slope[1] / length);
    };
    EXPECT_LT(error(high.normals[i]), 0.05) << i;
    EXPECT_TRUE(std::isfinite(high.normals[i].residual)) << i;
    higher += error(high.normals[i]) < error(low.normals[i]) ? 1 : 0;
  }
  EXPECT_GT(higher, grid.size() / 2) << "the degree that was asked for where it can be had";
}

// A hundred copies of one point have no normals.
TestPoints SphereWithCopies() {
  TestPoints sphere = Sphere(4900, 1.0);
  for (int copy = 1; copy < 100; ++copy) {
    sphere.positions.push_back(sphere.positions[0]);
    sphere.normals.push_back(sphere.normals[0]);
  }
  return sphere;
}

TEST(MadeNormalsTest, PointsWithoutANormalSpoilNoNeighbor) {
  const TestPoints sphere = SphereWithCopies();
  for (const char* const estimator :
       {"avg-hexagram", "uniform", "independent", "hexagram", "delaunay", "aso", "normal-regression", "jet", "auto"}) {
    EstimatorOptions options = {.estimator = estimator, .neighborhood = NeighborCount{50}};
    const EstimationResult result = EstimateFromPositions(sphere, options, EstimateBy(NormalMethod::kJet2, 24));
    size_t ok = 0;
    for (const PointCurvature& point : result.field.points.span()) {
      if (point.status != PointStatus::kOk) continue;
      ++ok;
      EXPECT_NEAR(point.mean, 1.0, 0.05) << estimator;
    }
    EXPECT_GT(ok, 4800u) << estimator;
    EXPECT_LE(ok, 4900u) << estimator << ": copies have no normal";
  }
}

// Corners lie farther away than the neighbors that are searched for, and edges are looked for.
TEST(MadeNormalsTest, PointsWithoutANormalSpoilNoEstimateThatReachesThem) {
  const TestPoints sphere = SphereWithCopies();
  const EstimatorOptions corners = {.estimator = "hexagram", .neighborhood = NeighborCount{300}};
  for (const EstimatorOptions& options : {corners, Automatic()}) {
    const EstimationResult result = EstimateFromPositions(sphere, options, EstimateBy(NormalMethod::kJet2, 24));
    size_t ok = 0;
    for (const PointCurvature& point : result.field.points.span()) {
      if (point.status != PointStatus::kOk) continue;
      ++ok;
      EXPECT_NEAR(point.mean, 1.0, 0.1) << options.estimator;
    }
    EXPECT_GT(ok, 4400u) << options.estimator;
  }
}

TEST(MadeNormalsTest, PointsWithoutANormalSpoilNoNeighborAtAnyScale) {
  EstimatorOptions options = {.neighborhood = NeighborCount{100}};
  options.smaller_counts.counts[options.smaller_counts.size++] = 50;
  const TestPoints sphere = SphereWithCopies();
  const NormalOptions normals = EstimateBy(NormalMethod::kJet2, 24);
  const EstimationResult both = EstimateFromPositions(sphere, options, normals);
  const EstimationResult alone = EstimateFromPositions(sphere, {.neighborhood = NeighborCount{50}}, normals);
  ASSERT_EQ(both.smaller.size(), 1u);
  EXPECT_EQ(FirstDifference(both.smaller[0].span(), alone.field.points.span()), sphere.size());
}

TEST(MadeNormalsTest, ACountThatTheCloudLacksIsTheReasonOfPointsWithoutANormal) {
  EstimatorOptions options = {.neighborhood = NeighborCount{65}};
  options.smaller_counts.counts[options.smaller_counts.size++] = 16;
  TestPoints line;
  for (int i = 0; i < 63; ++i) line.Add(0.1f * static_cast<float>(i), 0.0f, 0.0f, 0.0f, 0.0f, 1.0f);
  const EstimationResult both = EstimateFromPositions(line, options, EstimateBy(NormalMethod::kJet2, 24));
  EXPECT_EQ(both.field.points[0].status, PointStatus::kTooFewNeighbors);
  EXPECT_EQ(both.smaller[0][0].status, PointStatus::kSingularFit);
  EXPECT_EQ(both.field.status_counts[static_cast<size_t>(PointStatus::kTooFewNeighbors)], 63u);
  EXPECT_EQ(both.field.status_counts[static_cast<size_t>(PointStatus::kSingularFit)], 63u);
}

// The share of the points of a sphere of radius 1 whose intervals hold the mean curvature; of those that have one,
// which are to be nearly all.
double ShareWithin(const EstimationResult& result) {
  size_t known = 0, within = 0;
  for (size_t i = 0; i < result.choices.size(); ++i) {
    const PointChoice& choice = result.choices[i];
    EXPECT_EQ(std::isnan(choice.mean_error), std::isnan(choice.k1_error));
    EXPECT_EQ(std::isnan(choice.mean_error), std::isnan(choice.k2_error));
    if (std::isnan(choice.mean_error)) continue;
    ++known;
    within += std::abs(result.field.points[i].mean - 1.0) <= 1.645 * choice.mean_error ? 1 : 0;
  }
  EXPECT_GT(known, result.choices.size() * 9 / 10);
  return static_cast<double>(within) / static_cast<double>(known);
}

TEST(MadeNormalsTest, EstimatesKnowHowSureTheyAre) {
  EstimatorOptions jets = Automatic();
  jets.estimator = "jet";
  jets.jet_degree = 4;
  for (const double noise : {0.0, 0.005}) {
    const TestPoints sphere = NoisySphere(kSanitized ? 4'000 : 10'000, noise);
    for (const EstimatorOptions& options : {jets, Automatic(), EstimatorOptions{.neighborhood = NeighborCount{100}}}) {
      const EstimationResult result = EstimateFromPositions(sphere, WithChoice(options), Estimated());
      EXPECT_GT(ShareWithin(result), 0.8) << options.estimator << " noise " << noise;
    }
  }
}

// Too few neighbors for halves, by the caller's wish and not since positions are exact.
TEST(MadeNormalsTest, ErrorsThatNeighborsShareHaveNoIntervals) {
  const EstimationResult result =
      EstimateFromPositions(NoisySphere(10'000, 0.005), WithChoice(Automatic()), EstimateBy(NormalMethod::kJet2, 20));
  size_t unknown = 0;
  for (const PointChoice& choice : result.choices.span()) {
    EXPECT_TRUE(std::isnan(choice.mean_error) || choice.jet_weight > 0.999f);
    EXPECT_FALSE(std::isnan(choice.neighbor_count)) << "what was chosen is known";
    unknown += std::isnan(choice.mean_error) ? 1 : 0;
  }
  EXPECT_GT(unknown, 5'000u);
  EXPECT_FALSE(result.scale_report->normal_sigma.has_value()) << "what neighbors share is no noise of their own";
}

TEST(MadeNormalsTest, AnUnknownEstimatorIsRefused) {
  WorkerPool pool(1);
  EstimatorOptions options = Automatic();
  options.estimator = "nothing";
  const auto result = EstimateCurvature(BareCloud(NoisySphere(1'000, 0.01)), options, Estimated(), pool);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument) << result.status();
}

// Normals are made before they are oriented, and those of halves after that.
TEST(MadeNormalsTest, SecondsAreThoseOfAllPhasesOfAName) {
  const EstimationResult result = EstimateFromPositions(NoisySphere(5'000, 0.01), Automatic(), Estimated());
  double seconds = 0.0;
  size_t times = 0;
  for (const PhaseTime& phase : result.cost.phases) {
    if (phase.name != "normals") continue;
    seconds += phase.seconds;
    ++times;
  }
  EXPECT_GE(times, 2u);
  EXPECT_DOUBLE_EQ(result.cost.seconds.normals.value_or(0.0), seconds);
}

double MeanErrorOn(const TestPoints& sphere, const EstimatorOptions& options) {
  const EstimationResult result = EstimateFromPositions(sphere, options, Estimated());
  double sum = 0.0;
  for (const PointCurvature& point : result.field.points.span()) sum += std::abs(point.mean - 1.0);
  return sum / static_cast<double>(result.field.points.size());
}

// Without halves, errors that neighbors share look like detail, and too few neighbors are chosen: H erred three times
// as much as by the best of the two.
TEST(MadeNormalsTest, ErrorsThatNeighborsShareAreNotTakenForDetail) {
  const TestPoints sphere = NoisySphere(kSanitized ? 8'000 : 20'000, 0.01);
  EstimatorOptions fixed{.estimator = "normal-regression", .neighborhood = NeighborCount{1024}};
  const double best = std::min(MeanErrorOn(sphere, fixed), MeanErrorOn(sphere, {.neighborhood = NeighborCount{1024}}));
  EXPECT_LT(MeanErrorOn(sphere, Automatic()), 1.1 * best);
}

}  // namespace
}  // namespace curvd::testing
