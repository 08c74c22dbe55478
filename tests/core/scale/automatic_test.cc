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
