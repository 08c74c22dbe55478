// Automatic estimates of clouds with seams: what reaches across one does not count, and refuses nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "core/scale/automatic.h"
#include "tests/core/estimators/run_in_parts.h"
#include "tests/core/scale/automatic_requests.h"
#include "tests/core/seam_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

using ::testing::IsEmpty;

constexpr size_t kPoints = 12'000;
// Enough for seams, where results are compared with each other alone.
constexpr size_t kFewPoints = 4000;

struct Terrain {
  TestPoints points;
  Flips flips;
  std::vector<double> mean;  // the true mean curvature at each point
};

// A gentle ground over [0, 1] x [0, 1], seen from above, with trees: 9 discs in which normals point to either side by
// chance. Of kPoints, neighborhoods of a thousand hold one of them everywhere, those of a hundred seldom.
Terrain GroundWithTrees(size_t points = kPoints) {
  constexpr double kWave = 5.0, kHeight = 0.02, kDisc = 0.02;
  Terrain terrain;
  TestPoints plane = Plate(2 * points, 0.0, 11);  // two faces of 2 x 2, every other point to each
  for (size_t i = 0; i < plane.size(); i += 2) {
    const double x = 0.5 * plane.positions[i][0], y = 0.5 * plane.positions[i][1];
    const double z = kHeight * std::sin(kWave * x), slope = kHeight * kWave * std::cos(kWave * x);
    const double length = std::hypot(slope, 1.0);
    terrain.points.Add(x, y, z, -slope / length, 0.0, 1.0 / length);
    terrain.mean.push_back(0.5 * kWave * kWave * z / (length * length * length));
  }
  AddNoise(0.0003, 0.03, 12, terrain.points);
  TestPoints flipped = terrain.points;
  terrain.flips = FlipAtRandom(0.5, 13, flipped);
  for (size_t i = 0; i < flipped.size(); ++i) {
    const auto off_center = [](double at) { return std::abs(3.0 * at - std::floor(3.0 * at) - 0.5) / 3.0; };
    const auto& p = flipped.positions[i];
    if (std::hypot(off_center(p[0]), off_center(p[1])) < kDisc) {
      terrain.points.normals[i] = flipped.normals[i];
    } else {
      terrain.flips[i] = 0;
    }
  }
  return terrain;
}

struct CountRange {
  uint32_t least = ~0u, most = 0;
};

CountRange ChosenCounts(const EstimationResult& result) {
  CountRange range;
  for (const ScaleOutcome& outcome : result.scale_report->outcomes) {
    if (outcome.share == 0.0) continue;
    range.least = std::min(range.least, outcome.neighbor_count);
    range.most = std::max(range.most, outcome.neighbor_count);
  }
  return range;
}

size_t OkOf(const EstimationResult& result) {
  return result.field.status_counts[static_cast<size_t>(PointStatus::kOk)];
}

EstimationResult WithCount(const Terrain& terrain, uint32_t count) {
  return MustEstimate(terrain.points.ToCloud(), {.neighborhood = NeighborCount{count}});
}

// Points that are served, and that their largest neighborhoods would not serve. The radius is how far they looked.
size_t MendedCount(const Terrain& terrain, const EstimationResult& result) {
  const EstimationResult largest = WithCount(terrain, ChosenCounts(result).most);
  size_t mended = 0;
  for (size_t i = 0; i < result.field.points.size(); ++i) {
    const PointCurvature &point = result.field.points[i], &of_largest = largest.field.points[i];
    const bool is_refused = of_largest.status == PointStatus::kOpposedNormals;
    mended += point.status == PointStatus::kOk && is_refused && point.radius < of_largest.radius ? 1 : 0;
  }
  return mended;
}

TEST(AutomaticSeamsTest, PointsThatTheSmallestNeighborhoodsServeAreServed) {
  const Terrain terrain = GroundWithTrees();
  const EstimationResult result = MustEstimate(terrain.points.ToCloud(), Automatic());
  const CountRange chosen = ChosenCounts(result);
  const EstimationResult smallest = WithCount(terrain, chosen.least), largest = WithCount(terrain, chosen.most);
  ASSERT_LT(OkOf(largest), kPoints / 2) << "large neighborhoods cannot serve the cloud";
  // Points beside edges are estimated from one side, which takes a neighborhood that is a little larger.
  EXPECT_GE(OkOf(result), OkOf(smallest) * 9 / 10) << chosen.least << " to " << chosen.most;
  EXPECT_GT(OkOf(result), 3 * OkOf(largest) / 2);
  EXPECT_THAT(OkAcrossSeams(terrain.points, terrain.flips, result.field), IsEmpty());
}

TEST(AutomaticSeamsTest, WhatIsLeftIsRight) {
  const Terrain terrain = GroundWithTrees();
  const EstimationResult result = MustEstimate(terrain.points.ToCloud(), Automatic());
  const EstimationResult smallest = WithCount(terrain, ChosenCounts(result).least);
  double error = 0.0, error_of_smallest = 0.0;
  for (size_t i = 0; i < kPoints; ++i) {
    if (result.field.points[i].status != PointStatus::kOk || smallest.field.points[i].status != PointStatus::kOk)
      continue;
    ASSERT_TRUE(std::isfinite(result.field.points[i].mean));
    error += std::abs(result.field.points[i].mean - terrain.mean[i]);
    error_of_smallest += std::abs(smallest.field.points[i].mean - terrain.mean[i]);
  }
  EXPECT_LT(error, 1.02 * error_of_smallest) << "larger neighborhoods are used where they reach no seam";
}

TEST(AutomaticSeamsTest, CountsAreThoseOfTheField) {
  const EstimationResult result = MustEstimate(GroundWithTrees().points.ToCloud(), Automatic());
  std::array<uint64_t, kPointStatusEnd> counts{};
  for (const PointCurvature& point : result.field.points.span()) ++counts[static_cast<size_t>(point.status)];
  EXPECT_EQ(counts, result.field.status_counts);
}

TEST(AutomaticSeamsTest, ThreadsChangeNoByte) {
  const Terrain terrain = GroundWithTrees(kFewPoints);
  EstimatorOptions options = Automatic();
  options.returns_choice = true;
  const EstimationResult one = MustEstimate(terrain.points.ToCloud(), options, 1);
  const EstimationResult three = MustEstimate(terrain.points.ToCloud(), options, 3);
  EXPECT_GT(MendedCount(terrain, one), 0u);
  EXPECT_EQ(FirstDifference(one.field.points.span(), three.field.points.span()), kFewPoints);
  EXPECT_EQ(std::memcmp(one.choices.data(), three.choices.data(), one.choices.bytes()), 0);
  const EstimationResult without = MustEstimate(terrain.points.ToCloud(), Automatic());
  EXPECT_EQ(FirstDifference(one.field.points.span(), without.field.points.span()), kFewPoints);
}

TEST(AutomaticSeamsTest, ChoicesAreThoseThatWereUsed) {
  const Terrain terrain = GroundWithTrees();
  EstimatorOptions options = Automatic();
  options.returns_choice = true;
  const EstimationResult result = MustEstimate(terrain.points.ToCloud(), options);
  for (size_t i = 0; i < kPoints; ++i) {
    const PointCurvature& point = result.field.points[i];
    const PointChoice& choice = result.choices[i];
    if (point.status != PointStatus::kOk) {
      EXPECT_TRUE(std::isnan(choice.neighbor_count) && std::isnan(choice.mean_error));
      continue;
    }
    if (!std::isnan(choice.neighbor_count)) {
      EXPECT_NEAR(SumOfWeights(choice), 1.0f, 1e-5f);
    }
  }
  EXPECT_GT(MendedCount(terrain, result), 0u);
}

// A run of a group may leave some of it to the next, also where points are estimated again.
TEST(AutomaticSeamsTest, GroupsInPartsGiveTheSameBytes) {
  const SpatialIndex index = BuildIndex(GroundWithTrees(kFewPoints).points.ToCloud());
  const auto estimate = [&](uint64_t most_work) {
    std::vector<PointCurvature> results(index.point_count());
    SeamMarks marks = *SeamMarks::Create(index.group_count());
    const auto run = StrategyFor(Automatic()).start(Automatic(), index, results.data());
    const auto scratch = run->MakeScratch();
    scratch->seams = &marks;
    scratch->most_work = most_work;
    RunInParts(*run, index, *scratch);
    EXPECT_TRUE(marks.ShowSeam());
    return results;
  };
  const auto whole = estimate(WorkerScratch::kMostRunWork), parts = estimate(20'000);
  EXPECT_EQ(FirstDifference(whole, parts), kFewPoints);
}

// A cloud to be rejected is rejected, whatever could be left of it.
TEST(AutomaticSeamsTest, TheCallerMayStillReject) {
  EstimatorOptions options = Automatic();
  options.opposed_normals = OpposedNormalsPolicy::kReject;
  WorkerPool pool(2);
  EXPECT_FALSE(EstimateCurvature(GroundWithTrees().points.ToCloud(), options, pool).ok());
}

}  // namespace
}  // namespace curvd::testing
