#include "core/scale/automatic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/job/job_memory.h"
#include "core/scale/pilot/pilot.h"
#include "tests/core/estimators/run_in_parts.h"
#include "tests/core/hostile_clouds.h"
#include "tests/core/normals/normal_clouds.h"
#include "tests/core/scale/automatic_requests.h"
#include "tests/core/seam_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// Exact where x is negative.
TestPoints HalfNoisySphere(size_t points) {
  TestPoints halves = NoisySphere(points, 0.0);
  const TestPoints noisy = NoisySphere(points, 0.01);
  for (size_t i = 0; i < points; ++i) {
    if (halves.positions[i][0] < 0.0f) continue;
    halves.positions[i] = noisy.positions[i];
    halves.normals[i] = noisy.normals[i];
  }
  return halves;
}

TEST(AutomaticTest, IsNearTheBestOfAllFixedScales) {
  for (const double sigma : {0.0, 0.003, 0.01}) {
    const TestPoints sphere = NoisySphere(10'000, sigma);
    double best = 1e300;
    for (const uint32_t count : {16u, 32u, 64u, 128u, 256u, 512u, 1024u}) {
      EstimatorOptions options{.neighborhood = NeighborCount{count}};
      best = std::min(best, MeanError(MustEstimate(sphere.ToCloud(), options), 1.0));
    }
    EXPECT_LT(MeanError(MustEstimate(sphere.ToCloud(), Automatic()), 1.0), 1.2 * best) << sigma;
  }
}

TEST(AutomaticTest, TellsWhatItChose) {
  const EstimationResult result = MustEstimate(NoisySphere(10'000, 0.01).ToCloud(), Automatic());
  ASSERT_TRUE(result.scale_report.has_value());
  const ScaleReport& report = *result.scale_report;
  EXPECT_GT(report.sampled_points, 400u);
  EXPECT_NEAR(report.sigma, 0.01, 0.002);
  std::map<std::string, double> shares;
  double sum = 0.0;
  for (const ScaleOutcome& outcome : report.outcomes) {
    EXPECT_TRUE(outcome.error > 0.0 && outcome.noise >= 0.0 && outcome.bias >= 0.0);
    shares[std::string(outcome.estimator)] += outcome.share;
    sum += outcome.share;
  }
  EXPECT_NEAR(sum, 1.0, 1e-9);
  EXPECT_TRUE(shares.contains("avg-hexagram") && shares.contains("jet"));
}

TEST(AutomaticTest, TellsWhatItChoseForEachPart) {
  const EstimationResult result = MustEstimate(HalfNoisySphere(10'000).ToCloud(), WithChoice(Automatic()));
  EXPECT_GT(result.scale_report->sampled_points, Pilot::kMostPoints);
  double sum = 0.0, least = 1e300, most = 0.0;
  for (const ScaleOutcome& outcome : result.scale_report->outcomes) {
    sum += outcome.share;
    if (outcome.share < 0.1) continue;
    least = std::min(least, outcome.error);
    most = std::max(most, outcome.error);
  }
  EXPECT_NEAR(sum, 1.0, 1e-9);
  EXPECT_LT(least, 1e-2 * most) << "the exact half errs by far less";
  EXPECT_NEAR(result.scale_report->sigma, 0.01, 0.002);
  const TestPoints sphere = NoisySphere(10'000, 0.0);
  double exact = 0.0, noisy = 0.0;
  for (size_t i = 0; i < sphere.size(); ++i) {
    (sphere.positions[i][0] < 0.0f ? exact : noisy) += result.choices.span()[i].mean_error;
  }
  EXPECT_LT(exact, 0.3 * noisy) << "so do the standard errors, but for the border";
}

// Where small neighborhoods are best by far, larger ones are looked at by a few of the sampled points alone.
TEST(AutomaticTest, ScalesFarBeyondTheBestAreNotJudged) {
  const auto largest = [](const TestPoints& points) {
    const EstimationResult result = MustEstimate(points.ToCloud(), Automatic());
    uint32_t count = 0;
    for (const ScaleOutcome& outcome : result.scale_report->outcomes) {
      count = std::max(count, outcome.neighbor_count);
    }
    return count;
  };
  EXPECT_LE(largest(Waves(10'000, 0.0, 5)), 1024u);
  EXPECT_EQ(largest(NoisySphere(10'000, 0.02)), 2048u);
}

// Lines along a cylinder of radius 1, as a scanner leaves them, 20 and 40 times as far apart as the points on them.
// Small neighborhoods lie on one line, and noise alone makes them wider than that: they would call the cylinder a
// plane.
TEST(AutomaticTest, LooksAcrossTheLinesOfAScan) {
  constexpr double kBetweenLines = 0.05, kNoise = 1e-4;
  for (const size_t ratio : {20u, 40u}) {
    TestPoints lines;
    for (size_t line = 0; line < 20; ++line) {
      const double angle = kBetweenLines * static_cast<double>(line);
      const float x = static_cast<float>(std::cos(angle)), y = static_cast<float>(std::sin(angle));
      for (size_t i = 0; i < 20 * ratio; ++i) {
        // Lines do not begin at one height.
        const double height = kBetweenLines * (static_cast<double>(i) / static_cast<double>(ratio) + 0.37 * line);
        lines.positions.push_back({x, y, static_cast<float>(height)});
        lines.normals.push_back({x, y, 0.0f});
      }
    }
    AddNoise(kNoise, 3, lines);
    const EstimationResult result = MustEstimate(lines.ToCloud(), Automatic());
    // A plane would be off by 0.5; what noise does to two neighboring lines is far less than this.
    EXPECT_LT(MeanError(result, 0.5), 0.05) << ratio;
  }
}

TEST(AutomaticTest, FixedEstimatesTellNothing) {
  EXPECT_FALSE(MustEstimate(Sphere(1000, 1.0).ToCloud(), {}).scale_report.has_value());
}

TEST(AutomaticTest, OneEstimatorMayBeFixedOrTheCount) {
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
TEST(AutomaticTest, BoundsBetweenTwoScalesLeaveTheEstimator) {
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

// Whatever the fewest neighbors of a choice are.
TEST(AutomaticTest, ARadiusAsksForNoNumberOfPoints) {
  EstimatorOptions options;
  options.neighborhood = NeighborRadius{1.0};
  options.max_neighbor_count = 12;
  EXPECT_EQ(LeastPoints(options), 0u);
}

TEST(AutomaticTest, NeverLooksFartherThanItMay) {
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

TEST(AutomaticTest, SmallCloudsHaveAReasonOrNumbers) {
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

TEST(AutomaticTest, APlaneIsFlat) {
  TestPoints plane;
  for (int i = 0; i < 10'000; ++i) plane.Add(0.01 * (i % 100), 0.01 * (i / 100), 0.0, 0.0, 0.0, 1.0);
  const EstimationResult result = MustEstimate(plane.ToCloud(), Automatic());
  EXPECT_EQ(result.field.status_counts[static_cast<size_t>(PointStatus::kOk)], 10'000u);
  for (const PointCurvature& point : result.field.points.span()) EXPECT_NEAR(point.mean, 0.0, 1e-6);
}

TEST(AutomaticTest, NoiseInOneHalfDoesNotSpoilTheOther) {
  const TestPoints clean = NoisySphere(10'000, 0.0), noisy = NoisySphere(10'000, 0.01),
                   halves = HalfNoisySphere(10'000);
  const EstimationResult both = MustEstimate(halves.ToCloud(), Automatic());
  // Of the points that lie so far on one side that neighborhoods are of one half.
  const auto error_on = [&](float side, const EstimationResult& result) {
    double error = 0.0;
    for (size_t i = 0; i < clean.size(); ++i) {
      if (side * clean.positions[i][0] > 0.4f) error += std::abs(result.field.points[i].mean - 1.0);
    }
    return error;
  };
  EXPECT_LT(error_on(1.0f, both), 1.3 * error_on(1.0f, MustEstimate(noisy.ToCloud(), Automatic())));
  // An exact sphere alone has no error at all.
  const double rounding = 1e-5 * static_cast<double>(clean.size());
  EXPECT_LT(error_on(-1.0f, both), 1.3 * error_on(-1.0f, MustEstimate(clean.ToCloud(), Automatic())) + rounding);
}

// The graph of a bump over a square, exact where x is negative, and its mean curvature.
struct HalfNoisyBump {
  TestPoints points;
  std::vector<double> mean;
};

HalfNoisyBump MakeHalfNoisyBump(size_t points, uint64_t seed) {
  HalfNoisyBump bump;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  TestPoints noisy;
  for (size_t i = 0; i < points; ++i) {
    const double x = coordinate(random), y = coordinate(random), z = 0.2 * std::exp(-5.0 * (x * x + y * y));
    const double zx = -10.0 * x * z, zy = -10.0 * y * z, zxx = (100.0 * x * x - 10.0) * z,
                 zyy = (100.0 * y * y - 10.0) * z, zxy = 100.0 * x * y * z, w = 1.0 + zx * zx + zy * zy;
    TestPoints& half = x < 0.0 ? bump.points : noisy;
    half.Add(x, y, z, -zx / std::sqrt(w), -zy / std::sqrt(w), 1.0 / std::sqrt(w));
    if (x >= 0.0) continue;
    bump.mean.push_back(-((1.0 + zx * zx) * zyy - 2.0 * zx * zy * zxy + (1.0 + zy * zy) * zxx) /
                        (2.0 * w * std::sqrt(w)));
  }
  AddNoise(0.01, 0.2, seed, noisy);
  Append(noisy, bump.points);
  return bump;
}

// Neighborhoods that suit exact points, and reach over the border, err by tens: noise counts a hundred times there.
TEST(AutomaticTest, ExactPointsBesideNoisyOnesAreNotSpoiled) {
  for (const uint64_t seed : {1, 2, 3}) {
    const HalfNoisyBump bump = MakeHalfNoisyBump(20'000, seed);
    const EstimationResult result = MustEstimate(bump.points.ToCloud(), WithChoice(Automatic()));
    size_t unsure = 0;
    for (size_t i = 0; i < bump.mean.size(); ++i) {
      ASSERT_EQ(result.field.points[i].status, PointStatus::kOk);
      const double error = std::abs(result.field.points[i].mean - bump.mean[i]);
      EXPECT_LT(error, 0.6) << bump.points.positions[i][0];
      unsure += error > 0.05 && error > 5.0 * result.choices[i].mean_error ? 1 : 0;
    }
    // Those that the noisy half's estimates serve, with its errors.
    EXPECT_LE(unsure, 50u) << "points that are off by much more than they say";
  }
}

// Copies share their noise, with which halves of a neighborhood would agree, and look like faces of an edge.
TEST(AutomaticTest, CopiesOfNoisyPointsAreNoNews) {
  TestPoints sphere = Sphere(4000, 1.0);
  AddNoise(0.01, 0.2, 3, sphere);
  // 2,048 neighbors of three copies hold 683 points.
  AutomaticScale as_many;
  as_many.most_count = 724;
  const EstimationResult alone = MustEstimate(sphere.ToCloud(), WithChoice(Automatic(as_many)));
  for (const double rounding : {0.0, 1e-6}) {
    TestPoints copies = sphere;
    for (uint64_t copy = 1; copy < 3; ++copy) {
      TestPoints more = sphere;
      AddNoise(rounding, copy, more);
      Append(more, copies);
    }
    const EstimationResult result = MustEstimate(copies.ToCloud(), WithChoice(Automatic()));
    EXPECT_LT(MeanError(result, 1.0), 1.3 * MeanError(alone, 1.0));
    EXPECT_NEAR(result.scale_report->sigma, 0.01, 0.002);
    for (size_t i = 0; i < copies.size(); ++i) {
      ASSERT_EQ(result.field.points[i].status, PointStatus::kOk);
      ASSERT_FALSE(std::isnan(result.choices[i].mean_error)) << "as beside an edge";
      ASSERT_NEAR(result.field.points[i].mean, 1.0, 0.2);
    }
  }
}

TEST(AutomaticTest, AFarOutlierSpoilsNothing) {
  TestPoints sphere = Sphere(5000, 1.0);
  sphere.Add(1e30, 1e30, 1e30, 0.0, 0.0, 1.0);
  const EstimationResult result = MustEstimate(sphere.ToCloud(), Automatic());
  for (const PointCurvature& point : result.field.points.span().first(5000)) {
    EXPECT_TRUE(point.status != PointStatus::kOk || std::abs(point.mean - 1.0f) < 0.1f) << point.mean;
  }
}

TEST(AutomaticTest, NeitherThreadsNorUnitChangeAByte) {
  TestPoints sphere = NoisySphere(5000, 0.01);
  const EstimationResult one = MustEstimate(sphere.ToCloud(), Automatic(), 1);
  const EstimationResult three = MustEstimate(sphere.ToCloud(), Automatic(), 3);
  EXPECT_EQ(FirstDifference(one.field.points.span(), three.field.points.span()), 5000u);
  for (auto& position : sphere.positions) {
    for (float& coordinate : position) coordinate *= 0x1p20f;
  }
  const EstimationResult large = MustEstimate(sphere.ToCloud(), Automatic());
  for (size_t i = 0; i < 5000; ++i) EXPECT_EQ(large.field.points[i].k2 * 0x1p20f, one.field.points[i].k2);
}

TEST(AutomaticTest, NoiseOfNormalsIsFound) {
  TestPoints sphere = Sphere(10'000, 1.0);
  std::mt19937 random(6);
  std::normal_distribution<float> noise(0.0f, 0.1f);
  for (auto& normal : sphere.normals) {
    for (float& component : normal) component += noise(random);
  }
  EXPECT_NEAR(*MustEstimate(sphere.ToCloud(), Automatic()).scale_report->normal_sigma, 0.1, 0.01);
  EXPECT_LT(*MustEstimate(NoisySphere(10'000, 0.01).ToCloud(), Automatic()).scale_report->normal_sigma, 0.005)
      << "the normals of a noisy sphere are exact, but of other places: half of the 0.01 that this makes";
}

TEST(AutomaticTest, OptionsOutOfRangeAreRefused) {
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

TEST(AutomaticTest, ScratchNeverHoldsMoreThanItsBound) {
  for (const uint32_t most : {16u, 128u, 2048u}) {
    for (const Layout layout : kLayouts) {
      ExpectMemoryWithinItsBounds(BuildIndex(RandomPoints(layout, 3000, 5).ToCloud()), most, LayoutName(layout));
    }
    ExpectMemoryWithinItsBounds(BuildIndex(HalfNoisySphere(3000).ToCloud()), most, "half noisy");
  }
  const SpatialIndex large = BuildIndex(HalfNoisySphere(20'000).ToCloud());
  EXPECT_GT(ExpectMemoryWithinItsBounds(large, 512, "half noisy, with points between"), Pilot::kMostPoints);
}

TEST(AutomaticTest, WhatWorkersShareIsReservedOnce) {
  constexpr size_t kPoints = 1'000'000;
  const auto reserved = [](int threads) { return EstimationScratchBytes(Automatic(), kPoints, threads); };
  const Strategy& strategy = StrategyFor(Automatic());
  const size_t of_worker = strategy.scratch_bytes(Automatic(), kPoints);
  EXPECT_EQ(reserved(1), strategy.shared_bytes(Automatic(), kPoints) + of_worker);
  EXPECT_EQ(reserved(8), reserved(1) + 7 * of_worker);
}

// A run of a group may leave some of it to the next; that must not change what comes out.
TEST(AutomaticTest, GroupsInPartsGiveTheSameBytes) {
  const SpatialIndex index = BuildIndex(HalfNoisySphere(3000).ToCloud());
  const auto estimate = [&](uint64_t most_work) {
    std::vector<PointCurvature> results(index.point_count());
    const auto run = StrategyFor(Automatic()).start(Automatic(), index, results.data());
    const auto scratch = run->MakeScratch();
    scratch->most_work = most_work;
    RunInParts(*run, index, *scratch);
    EXPECT_EQ(scratch->status_counts[static_cast<size_t>(PointStatus::kOk)], 3000u);
    return results;
  };
  const auto whole = estimate(WorkerScratch::kMostRunWork), parts = estimate(20'000);
  EXPECT_EQ(FirstDifference(whole, parts), 3000u);
}

class AutomaticHostileTest : public ::testing::TestWithParam<HostileCloud> {};

TEST_P(AutomaticHostileTest, GivesNumbersOrAReason) {
  constexpr size_t kPoints = 3000;
  TestPoints points;
  GetParam().make(kPoints, points.positions, points.normals);
  const EstimationResult one = MustEstimate(points.ToCloud(), WithChoice(Automatic()), 1);
  const EstimationResult two = MustEstimate(points.ToCloud(), WithChoice(Automatic()), 2);
  EXPECT_TRUE(AreSameBytes(one.choices, two.choices));
  for (const PointChoice& choice : one.choices.span()) {
    ASSERT_TRUE(std::isnan(choice.k1_error) || choice.k1_error > 0.0f);
  }
  for (const PointCurvature& point : one.field.points.span()) {
    if (point.status != PointStatus::kOk) continue;
    ASSERT_TRUE(std::isfinite(point.mean) && std::isfinite(point.gaussian) && point.k1 <= point.k2);
    ASSERT_GT(point.radius, 0.0f);
  }
  EXPECT_EQ(FirstDifference(one.field.points.span(), two.field.points.span()), kPoints);
}

INSTANTIATE_TEST_SUITE_P(EachCloud, AutomaticHostileTest,
                         ::testing::ValuesIn(HostileClouds().begin(), HostileClouds().end()),
                         [](const auto& info) { return IdentifierOf(info.param); });

}  // namespace
}  // namespace curvd::testing
