// Estimates by normals that are given, and were made of the positions by somebody else.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/job/estimation_job.h"
#include "core/job/job_memory.h"
#include "core/job/normals_job.h"
#include "tests/core/normals/normal_clouds.h"
#include "tests/core/normals/trust/probed_clouds.h"
#include "tests/core/sanitized.h"
#include "tests/core/scale/automatic_requests.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

constexpr size_t kSpherePoints = kSanitized ? 6'000 : 16'000;

// A unit sphere whose normals are those of planes through that many neighbors; outward, or on any side.
TestPoints SphereOfPlanes(uint32_t count, bool outward = true) {
  TestPoints sphere = NoisySphere(kSpherePoints, 0.01);
  const NormalResult made = MustMakeNormals(BareCloud(sphere), EstimateBy(NormalMethod::kPca, count));
  for (size_t i = 0; i < sphere.size(); ++i) {
    const float side = outward || i % 3 == 0 ? 1.0f : -1.0f;
    for (int axis = 0; axis < 3; ++axis) sphere.normals[i][axis] = side * made.normals[i].normal[axis];
  }
  return sphere;
}

EstimationResult Estimate(const TestPoints& points, const EstimatorOptions& options, const NormalOptions& normals = {},
                          int threads = 2) {
  WorkerPool pool(threads);
  absl::StatusOr<EstimationResult> result = EstimateCurvature(points.ToCloud(), options, normals, pool);
  EXPECT_TRUE(result.ok()) << result.status();
  return result.ok() ? *std::move(result) : EstimationResult{};
}

// A shell whose sheets are nearer to each other than neighborhoods are wide, with normals of planes.
TestPoints ShellOfPlanes(uint32_t count) {
  TestPoints shell = Sphere(kSpherePoints / 2, 1.0), inner = Sphere(kSpherePoints / 2, 0.95);
  for (auto& normal : inner.normals) normal = {-normal[0], -normal[1], -normal[2]};
  Append(inner, shell);
  AddNoise(0.002, 4, shell);
  return WithFittedNormals(std::move(shell), NormalMethod::kPca, count);
}

// The least error of fixed neighborhoods. Errors that are taken for detail let too few neighbors be chosen: H erred by
// 2 to 4 times as much.
double LeastError(const TestPoints& sphere) {
  double least = 1e300;
  for (const uint32_t count : {128, 256, 512, 1024}) {
    least = std::min(least, MeanError(Estimate(sphere, {.neighborhood = NeighborCount{count}}), 1.0));
  }
  return least;
}

double ShareWithin(const EstimationResult& result) {
  size_t within = 0;
  for (size_t i = 0; i < result.choices.size(); ++i) {
    within += std::abs(result.field.points[i].mean - 1.0) <= 1.645 * result.choices[i].mean_error ? 1 : 0;
  }
  return static_cast<double>(within) / static_cast<double>(result.choices.size());
}

TEST(FittedNormalsTest, ErrorsThatNeighborsShareAreNotTakenForDetail) {
  for (const uint32_t count : {12, 20, 30}) {
    const TestPoints sphere = SphereOfPlanes(count);
    const EstimationResult result = Estimate(sphere, WithChoice(Automatic()));
    EXPECT_LT(MeanError(result, 1.0), 1.1 * LeastError(sphere)) << count;
    EXPECT_GT(ShareWithin(result), 0.8) << count;
    ASSERT_TRUE(result.scale_report.has_value());
    EXPECT_FALSE(result.scale_report->normal_sigma.has_value()) << "no noise of their own";
    ASSERT_TRUE(result.scale_report->fitted_normals.has_value()) << count;
    EXPECT_EQ(result.scale_report->fitted_normals->method, NormalMethod::kPca);
    EXPECT_EQ(result.scale_report->fitted_normals->neighbor_count, count);
    EXPECT_FALSE(result.normal_report.has_value()) << "nobody asked for normals";
    EXPECT_FALSE(result.cost.seconds.normals.has_value());
  }
}

// Each normal a little off, so that nobody knows the fit again.
TestPoints Disguised(TestPoints points, float by) {
  for (size_t i = 0; i < points.size(); ++i) points.normals[i][i % 3] += by;
  return points;
}

EstimatorOptions AutomaticHexagrams() { return {.estimator = "avg-hexagram", .neighborhood = AutomaticScale()}; }

// Planes of few neighbors have much more noise than what curvd makes of the same positions.
TEST(FittedNormalsTest, AreMadeAnewWhereThatIsBetter) {
  for (const uint32_t count : {8, 12, 30}) {
    const TestPoints sphere = SphereOfPlanes(count);
    const EstimationResult result = Estimate(sphere, Automatic());
    ASSERT_TRUE(result.scale_report.has_value() && result.scale_report->normals_made_anew.has_value()) << count;
    EXPECT_EQ(result.scale_report->fitted_normals->neighbor_count, count);
    EXPECT_GT(result.scale_report->normals_made_anew->neighbor_count, 2 * count);
    EXPECT_LT(MeanError(result, 1.0), 0.5 * LeastError(sphere)) << count;
    NormalOptions make;
    make.source = NormalSource::kEstimate;
    make.sides = ConsistentSides{.closed = true};
    const EstimationResult made = Estimate(sphere, Automatic(), make);
    EXPECT_EQ(FirstDifference(result.field.points.span(), made.field.points.span()), sphere.size())
        << "the normals of the same positions, on the same sides";
  }
}

// Who knows the fit no more still sees that normals err as the positions do.
TEST(FittedNormalsTest, ThoseThatFollowTheNoiseAreMadeAnewAsWell) {
  for (const uint32_t count : {12, 30}) {
    const TestPoints sphere = SphereOfPlanes(count), disguised = Disguised(sphere, 0.02f);
    const EstimationResult known = Estimate(sphere, WithChoice(Automatic()));
    const EstimationResult result = Estimate(disguised, WithChoice(Automatic()));
    ASSERT_TRUE(result.scale_report.has_value() && result.scale_report->normals_made_anew.has_value()) << count;
    EXPECT_EQ(result.scale_report->normals_made_anew->neighbor_count,
              known.scale_report->normals_made_anew->neighbor_count);
    EXPECT_FALSE(result.scale_report->fitted_normals.has_value()) << "nobody knows";
    EXPECT_FALSE(result.scale_report->normal_sigma.has_value()) << "no noise of their own";
    EXPECT_EQ(FirstDifference(result.field.points.span(), known.field.points.span()), sphere.size());
    EXPECT_GT(ShareWithin(result), 0.8) << count;
    const EstimationResult named = Estimate(disguised, AutomaticHexagrams());
    EXPECT_FALSE(named.scale_report->normals_made_anew.has_value()) << "whoever names an estimator gets it by them";
  }
}

// The pass without outliers starts from the normals that were given, and says so.
TEST(FittedNormalsTest, OutliersLeaveNoTraceInThem) {
  TestPoints sphere = SphereOfPlanes(12);
  for (size_t i = 0; i < 20; ++i) {
    const auto p = sphere.positions[i * 97];
    sphere.Add(1.2 * p[0], 1.2 * p[1], 1.2 * p[2], p[0], p[1], p[2]);
  }
  const EstimationResult result = Estimate(sphere, Automatic());
  EXPECT_LE(result.cost.peak_bytes, sphere.size() * EstimationBytesPerPoint(Automatic()) +
                                        EstimationScratchBytes(Automatic(), sphere.size(), 2));
  EXPECT_GE(result.field.status_counts[static_cast<size_t>(PointStatus::kOutlier)], 20u);
  ASSERT_TRUE(result.scale_report.has_value());
  ASSERT_TRUE(result.scale_report->fitted_normals.has_value());
  EXPECT_EQ(result.scale_report->fitted_normals->method, NormalMethod::kPca);
  EXPECT_EQ(result.scale_report->fitted_normals->neighbor_count, 12u);
  EXPECT_TRUE(result.scale_report->normals_made_anew.has_value());
}

// Whoever names an estimator gets it by the normals that were given.
TEST(FittedNormalsTest, OnlyTheChoiceMakesThemAnew) {
  const EstimationResult result = Estimate(SphereOfPlanes(20), AutomaticHexagrams());
  ASSERT_TRUE(result.scale_report.has_value() && result.scale_report->fitted_normals.has_value());
  EXPECT_FALSE(result.scale_report->normals_made_anew.has_value());
}

TEST(FittedNormalsTest, GoodOnesAndThoseOfNoFitStay) {
  const TestPoints exact = NoisySphere(kSpherePoints, 0.01);
  NormalOptions make;
  make.source = NormalSource::kEstimate;
  const NormalResult best = MustMakeNormals(BareCloud(exact), make);
  for (const TestPoints& points : {exact, WithFittedNormals(exact, *best.report.method, best.report.neighbor_count)}) {
    const EstimationResult result = Estimate(points, Automatic());
    ASSERT_TRUE(result.scale_report.has_value());
    EXPECT_FALSE(result.scale_report->normals_made_anew.has_value()) << best.report.neighbor_count;
  }
}

// Those that point inward stay inward.
TEST(FittedNormalsTest, NewOnesKeepTheSides) {
  TestPoints sphere = SphereOfPlanes(12), inward = sphere;
  for (auto& normal : inward.normals) normal = {-normal[0], -normal[1], -normal[2]};
  const EstimationResult outward = Estimate(sphere, Automatic()), turned = Estimate(inward, Automatic());
  ASSERT_TRUE(turned.scale_report.has_value() && turned.scale_report->normals_made_anew.has_value());
  for (size_t i = 0; i < sphere.size(); ++i) {
    ASSERT_EQ(turned.field.points[i].status, outward.field.points[i].status);
    ASSERT_NEAR(turned.field.points[i].mean, -outward.field.points[i].mean, 1e-4);
  }
}

TEST(FittedNormalsTest, NormalsThatAreTurnedAreLikeThoseThatWere) {
  const TestPoints sphere = SphereOfPlanes(20), mixed = SphereOfPlanes(20, false);
  NormalOptions orient;
  orient.source = NormalSource::kOrient;
  orient.sides = ConsistentSides{.closed = true};
  const EstimationResult given = Estimate(sphere, Automatic()), turned = Estimate(mixed, Automatic(), orient);
  EXPECT_EQ(FirstDifference(given.field.points.span(), turned.field.points.span()), sphere.size());
}

TEST(FittedNormalsTest, JetsAreKnownAsWell) {
  TestPoints sphere = WithFittedNormals(NoisySphere(kSpherePoints, 0.01), NormalMethod::kJet2, 24);
  const EstimationResult result = Estimate(sphere, WithChoice(Automatic()));
  EXPECT_LT(MeanError(result, 1.0), 1.1 * LeastError(sphere));
  ASSERT_TRUE(result.scale_report.has_value());
  EXPECT_FALSE(result.scale_report->normal_sigma.has_value()) << "no noise of their own";
  ASSERT_TRUE(result.scale_report->fitted_normals.has_value());
  EXPECT_EQ(result.scale_report->fitted_normals->method, NormalMethod::kJet2);
  EXPECT_EQ(result.scale_report->fitted_normals->neighbor_count, 24u);
}

TEST(FittedNormalsTest, NormalsThatTheServerMakesAreNotGivenOnes) {
  NormalOptions make;
  make.source = NormalSource::kEstimate;
  const EstimationResult result = Estimate(NoisySphere(kSpherePoints, 0.01), WithChoice(Automatic()), make);
  ASSERT_TRUE(result.scale_report.has_value());
  EXPECT_FALSE(result.scale_report->fitted_normals.has_value());
}

// Planes mix the sheets, in both halves alike: such normals are taken as they come, like those that are slightly
// turned, and are not known again.
TEST(FittedNormalsTest, NormalsOfThinShellsHaveNoHalves) {
  const TestPoints shell = ShellOfPlanes(24), turned = Disguised(shell, 1e-3f);
  const auto error_of = [&](const TestPoints& points) {
    const EstimationResult result = Estimate(points, WithChoice(Automatic()));
    double error = 0.0;
    for (size_t i = 0; i < points.size(); ++i) {
      error += std::abs(result.field.points[i].mean - (i < points.size() / 2 ? 1.0 : -1.0 / 0.95));
    }
    return error;
  };
  EXPECT_LT(error_of(shell), 1.1 * error_of(turned)) << "1.27 times as much with halves";
}

TEST(FittedNormalsTest, ThreadsChangeNothing) {
  const TestPoints sphere = SphereOfPlanes(20);
  const EstimationResult one = Estimate(sphere, WithChoice(Automatic()), {}, 1);
  const EstimationResult four = Estimate(sphere, WithChoice(Automatic()), {}, 4);
  EXPECT_EQ(FirstDifference(one.field.points.span(), four.field.points.span()), sphere.size());
  EXPECT_TRUE(AreSameBytes(one.choices, four.choices));
}

// What is chosen changes nothing in an estimate that is not.
TEST(FittedNormalsTest, FixedEstimatesAreThoseOfTheGivenNormals) {
  const TestPoints sphere = SphereOfPlanes(20);
  const EstimatorOptions fixed = {.neighborhood = NeighborCount{128}};
  const EstimationResult with = Estimate(sphere, WithChoice(fixed)), without = Estimate(sphere, fixed);
  EXPECT_EQ(FirstDifference(with.field.points.span(), without.field.points.span()), sphere.size());
  EXPECT_GT(ShareWithin(with), 0.8);
}

// Also where the probes hold more than all else, as in small clouds.
TEST(FittedNormalsTest, MemoryIsReserved) {
  for (const size_t count : {size_t{300}, size_t{1'000}, size_t{2'000}, kSpherePoints}) {
    const TestPoints exact = NoisySphere(count, 0.01);
    for (const TestPoints& points : {exact, WithFittedNormals(exact, NormalMethod::kJet2, 24)}) {
      for (const EstimatorOptions& options :
           {WithChoice(Automatic()), WithChoice({.neighborhood = NeighborCount{32}})}) {
        const EstimationResult result = Estimate(points, options);
        EXPECT_LE(result.cost.peak_bytes, points.size() * EstimationBytesPerPoint(options, {}) +
                                              EstimationScratchBytes(options, points.size(), 2, {}))
            << count;
      }
    }
  }
}

// As many workers as a call has blocks can have scratch, however many threads the server has.
TEST(FittedNormalsTest, SmallCallsReserveNoMoreForManyThreads) {
  const EstimatorOptions options = WithChoice(Automatic());
  EXPECT_EQ(EstimationScratchBytes(options, 10, 64, {}), EstimationScratchBytes(options, 10, 2, {}));
  EXPECT_LT(EstimationScratchBytes(options, 60, 64, {}), 4 * EstimationScratchBytes(options, 60, 2, {}));
}

}  // namespace
}  // namespace curvd::testing
