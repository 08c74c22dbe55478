#include "core/scale/automatic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <string>

#include "core/base/error.h"
#include "core/scale/pilot.h"
#include "tests/core/hostile_clouds.h"
#include "tests/core/instruction_sets.h"
#include "tests/core/normals/normal_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

EstimatorOptions Automatic(AutomaticScale scale = {}) {
  return {.estimator = kAutomaticEstimator, .neighborhood = scale};
}

// Of the mean curvature, over the points that have one.
double MeanError(const EstimationResult& result, double truth) {
  double sum = 0.0;
  size_t count = 0;
  for (const PointCurvature& point : result.field.points.span()) {
    if (point.status != PointStatus::kOk) continue;
    sum += std::abs(point.mean - truth);
    ++count;
  }
  return sum / static_cast<double>(count);
}

TestPoints NoisySphere(size_t points, double sigma) {
  TestPoints sphere = Sphere(points, 1.0);
  AddNoise(sigma, 3, sphere);
  return sphere;
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

// A box of `side` x `side` points a face, a spacing of 1 apart, exact normals.
TestPoints Box(int side) {
  TestPoints box;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double end : {0.0, 1.0}) {
      for (int i = 0; i < side * side; ++i) {
        double at[3], normal[3] = {0.0, 0.0, 0.0};
        at[axis] = end * side;
        at[(axis + 1) % 3] = i % side + 0.5;
        at[(axis + 2) % 3] = i / side + 0.5;
        normal[axis] = 2.0 * end - 1.0;
        box.Add(at[0], at[1], at[2], normal[0], normal[1], normal[2]);
      }
    }
  }
  return box;
}

TEST(AutomaticTest, FacesOfABoxAreFlatUpToTheEdges) {
  TestPoints box = Box(30);
  const EstimationResult exact = MustEstimate(box.ToCloud(), Automatic());
  for (const PointCurvature& point : exact.field.points.span()) {
    ASSERT_EQ(point.status, PointStatus::kOk);
    EXPECT_NEAR(point.mean, 0.0, 0.01);  // avg-hexagram of 16 points errs by some 0.4 beside an edge
  }
  AddNoise(0.05, 3, box);
  EXPECT_LT(MeanError(MustEstimate(box.ToCloud(), Automatic()), 0.0), 0.01) << "a tenth of what avg-hexagram errs by";
}

TEST(AutomaticTest, NoiseInOneHalfDoesNotSpoilTheOther) {
  const TestPoints clean = NoisySphere(10'000, 0.0), noisy = NoisySphere(10'000, 0.01);
  TestPoints halves = clean;
  for (size_t i = 0; i < clean.size(); ++i) {
    if (clean.positions[i][0] < 0.0f) continue;
    halves.positions[i] = noisy.positions[i];
    halves.normals[i] = noisy.normals[i];
  }
  const EstimationResult both = MustEstimate(halves.ToCloud(), Automatic());
  const EstimationResult alone = MustEstimate(noisy.ToCloud(), Automatic());
  double error_of_both = 0.0, error_alone = 0.0;
  for (size_t i = 0; i < clean.size(); ++i) {
    if (clean.positions[i][0] < 0.3f) continue;  // neighborhoods there have both
    error_of_both += std::abs(both.field.points[i].mean - 1.0);
    error_alone += std::abs(alone.field.points[i].mean - 1.0);
  }
  EXPECT_LT(error_of_both, 1.3 * error_alone);
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
  EstimatorOptions radius = Automatic();
  radius.neighborhood = NeighborRadius{1.0};
  EXPECT_TRUE(refused(radius, "radius"));
  EstimatorOptions aso = Automatic();
  aso.estimator = "aso";
  EXPECT_TRUE(refused(aso, "estimator is \"aso\""));
  EstimatorOptions jet = Automatic();
  jet.estimator = "jet";
  EXPECT_TRUE(refused(jet, "jet_degree is 2"));
}

// As the job runs it, on one scratch.
TEST(AutomaticTest, ScratchNeverHoldsMoreThanItsBound) {
  for (const Layout layout : kLayouts) {
    const SpatialIndex index = BuildIndex(RandomPoints(layout, 3000, 5).ToCloud());
    for (const uint32_t most : {16u, 128u, 2048u}) {
      const EstimatorOptions options = Automatic({.most_count = most});
      std::vector<PointCurvature> results(index.point_count());
      const Strategy& strategy = StrategyFor(options);
      const auto run = strategy.start(options, index, results.data());
      const auto scratch = run->MakeScratch();
      for (const GroupPhase& phase : run->Phases()) {
        ASSERT_TRUE(phase.begin == nullptr || phase.begin().ok());
        for (size_t group = 0; group < index.group_count(); ++group) {
          ASSERT_TRUE(phase.run(group, *scratch).ok());
          EXPECT_LE(scratch->bytes(), strategy.scratch_bytes(options, index.point_count())) << LayoutName(layout);
        }
      }
    }
  }
}

// A run of a group may leave some of it to the next; that must not change what comes out.
TEST(AutomaticTest, GroupsInPartsGiveTheSameBytes) {
  const SpatialIndex index = BuildIndex(NoisySphere(3000, 0.01).ToCloud());
  const auto estimate = [&](uint64_t most_work) {
    std::vector<PointCurvature> results(index.point_count());
    const auto run = StrategyFor(Automatic()).start(Automatic(), index, results.data());
    const auto scratch = run->MakeScratch();
    scratch->most_work = most_work;
    for (const GroupPhase& phase : run->Phases()) {
      EXPECT_TRUE(phase.begin == nullptr || phase.begin().ok());
      for (size_t group = 0; group < index.group_count(); ++group) {
        scratch->first_point = 0;
        do {
          scratch->rest = 0;
          EXPECT_TRUE(phase.run(group, *scratch).ok());
          scratch->first_point = scratch->rest;
        } while (scratch->rest > 0);
      }
    }
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
  const EstimationResult one = MustEstimate(points.ToCloud(), Automatic(), 1);
  const EstimationResult two = MustEstimate(points.ToCloud(), Automatic(), 2);
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

class PilotTest : public InstructionSetTest {};

TEST_P(PilotTest, EstimatesTheSameOnEveryInstructionSet) {
  const SpatialIndex index = BuildIndex(NoisySphere(3000, 0.02).ToCloud());
  const Pilot pilot(index, 512);
  const auto sample = [&] {
    PilotTable table(pilot.sample_count(), PilotPoint::None());
    PilotScratch scratch;
    for (size_t group = 0; group < index.group_count(); ++group) {
      EXPECT_TRUE(pilot.SampleGroup(group, scratch, table).ok());
    }
    return table;
  };
  const PilotTable here = sample();
  hwy::SetSupportedTargetsForTest(0);
  const PilotTable anywhere = sample();
  ASSERT_EQ(here.size(), std::min(Pilot::kMostPoints, index.leaf_count()));
  for (size_t i = 0; i < here.size(); ++i) {
    ASSERT_TRUE(here[i].is_sampled());
    EXPECT_EQ(std::memcmp(&here[i].mean, &anywhere[i].mean, sizeof(here[i].mean)), 0) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, PilotTest, InstructionSets(), InstructionSetName);

}  // namespace
}  // namespace curvd::testing
