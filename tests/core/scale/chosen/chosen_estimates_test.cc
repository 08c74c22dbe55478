#include "core/scale/chosen/chosen_estimates.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "core/scale/automatic_options.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// avg-hexagram with 64 and with 256 neighbors, in this order.
ScaleChoice TwoScales(double small_weight, double large_weight) {
  ScaleChoice choice;
  choice.chosen = {{kHexagramMethod, RungNear(64)}, {kHexagramMethod, RungNear(256)}};
  for (ScaleWeights* const weights : {&choice.weights.mean, &choice.weights.traceless, &choice.weights.gaussian}) {
    weights->cloud_weights = {small_weight, large_weight};
  }
  return choice;
}

EstimatorOptions Automatic(double max_radius = 0.0) {
  return {.estimator = kAutomaticEstimator, .neighborhood = AutomaticScale{.max_radius = max_radius}};
}

// What every point of an index gets, by slot.
std::vector<PointCurvature> Averages(const SpatialIndex& index, const EstimatorOptions& options,
                                     const ScaleChoice& choice, bool positions_are_exact = false) {
  std::vector<PointCurvature> points(index.point_count());
  const CloudChoice of_cloud({{PilotPoints(), choice, positions_are_exact}});
  const ChosenEstimates estimates(options, index, of_cloud, nullptr, points.data());
  AutomaticScratch scratch;
  for (size_t group = 0; group < index.group_count(); ++group) {
    EXPECT_TRUE(estimates.EstimateGroup(group, scratch).ok());
    EXPECT_EQ(scratch.rest, 0u);
    for (size_t i = 0; i < scratch.points.size; ++i) {
      points[scratch.points.slot[i]] = ChosenEstimates::Blended(scratch, i);
    }
  }
  return points;
}

std::vector<PointCurvature> Fixed(const TestPoints& cloud, uint32_t count) {
  const EstimationResult result = MustEstimate(cloud.ToCloud(), {.neighborhood = NeighborCount{count}});
  const auto points = result.field.points.span();
  return {points.begin(), points.end()};
}

TEST(ChosenEstimatesTest, WhatHasLittleWeightDoesNotCount) {
  const TestPoints sphere = Sphere(2000, 1.0);
  const SpatialIndex index = BuildIndex(sphere.ToCloud());
  const std::vector<PointCurvature> small = Fixed(sphere, 64), large = Fixed(sphere, 256);
  for (const bool is_exact : {false, true}) {
    const double least = is_exact ? ChosenEstimates::kLeastWeightOfExact : ChosenEstimates::kLeastWeight;
    const auto without = Averages(index, Automatic(), TwoScales(1.0 - 0.9 * least, 0.9 * least), is_exact);
    const auto with = Averages(index, Automatic(), TwoScales(1.0 - 1.1 * least, 1.1 * least), is_exact);
    for (size_t i = 0; i < small.size(); ++i) {
      ASSERT_EQ(without[i].status, PointStatus::kOk);
      EXPECT_FLOAT_EQ(without[i].mean, small[i].mean);
      EXPECT_EQ(without[i].radius, small[i].radius);
      EXPECT_FLOAT_EQ(with[i].mean,
                      static_cast<float>((1.0 - 1.1 * least) * small[i].mean + 1.1 * least * large[i].mean));
      EXPECT_EQ(with[i].radius, large[i].radius);
    }
  }
}

TEST(ChosenEstimatesTest, WhatHasLittleWeightCountsWhereNothingElseHasCurvature) {
  const TestPoints sphere = Sphere(2000, 1.0);
  const SpatialIndex index = BuildIndex(sphere.ToCloud());
  const std::vector<PointCurvature> small = Fixed(sphere, 64);
  // 64 of 2,000 points of a sphere lie within 0.36, 256 within 0.72.
  const auto averages = Averages(index, Automatic(0.5), TwoScales(0.01, 0.99));
  for (size_t i = 0; i < small.size(); ++i) {
    ASSERT_EQ(averages[i].status, PointStatus::kOk);
    EXPECT_FLOAT_EQ(averages[i].mean, small[i].mean);
    EXPECT_EQ(averages[i].radius, small[i].radius);
  }
}

// Whatever part of a group is run: from any point of a leaf on, its points have the weights of the leaf's middle.
TEST(ChosenEstimatesTest, PointsOfALeafShareTheirWeights) {
  const TestPoints sphere = Sphere(2000, 1.0);
  const SpatialIndex index = BuildIndex(sphere.ToCloud());
  ScaleChoice choice = TwoScales(0.5, 0.5);
  PilotTable table;
  for (size_t i = 0; i < sphere.size(); i += 20) {
    table.emplace_back(sphere.positions[i]);
    for (ScaleWeights* const weights : {&choice.weights.mean, &choice.weights.traceless, &choice.weights.gaussian}) {
      weights->trends = {{1.0, 1.0, 1.0}, {2.0, 1.0, 0.5}};
      weights->local_differences.push_back({static_cast<float>(i + 1), static_cast<float>(sphere.size() - i)});
    }
  }
  std::vector<PointCurvature> points(index.point_count());
  const EstimatorOptions options = Automatic();
  const CloudChoice of_cloud({{table, choice}});
  const ChosenEstimates estimates(options, index, of_cloud, nullptr, points.data());
  CloudWeights expected(of_cloud);
  std::vector<decltype(AutomaticScratch::counts)> counts;
  for (const size_t first : {0u, 5u}) {
    AutomaticScratch scratch;
    scratch.first_point = first;
    estimates.Start(3, scratch);
    for (size_t i = 0; i < scratch.points.size; ++i) {
      const size_t leaf = static_cast<size_t>(scratch.points.place[i]) / SpatialIndex::kLeafSize;
      std::array<float, 3> middle;
      for (int axis = 0; axis < 3; ++axis) {
        middle[static_cast<size_t>(axis)] = 0.5f * index.leaf_lo(axis)[leaf] + 0.5f * index.leaf_hi(axis)[leaf];
      }
      expected.Start({middle, middle});
      EXPECT_EQ(scratch.WeightsAt(i).mean, expected.At(middle.data()).mean);
      EXPECT_EQ(scratch.WeightsAt(i).gaussian, expected.At(middle.data()).gaussian);
    }
    counts.push_back(scratch.counts);
  }
  EXPECT_EQ(counts[0], counts[1]);
}

TEST(ChosenEstimatesTest, OneRunEndsWithTheShortestOfItsEstimates) {
  const SpatialIndex index = BuildIndex(Sphere(500, 1.0).ToCloud());
  std::vector<PointCurvature> points(index.point_count());
  const CloudChoice choice({{PilotPoints(), TwoScales(0.5, 0.5)}});
  const EstimatorOptions options = Automatic();
  const ChosenEstimates estimates(options, index, choice, nullptr, points.data());
  AutomaticScratch scratch;
  scratch.most_work = 10'000;
  size_t runs = 0, done = 0;
  do {
    scratch.first_point = scratch.rest;
    ASSERT_TRUE(estimates.EstimateGroup(0, scratch).ok());
    done += scratch.points.size;
    EXPECT_EQ(scratch.rest, done == SpatialIndex::kGroupPoints ? 0 : done);
    ++runs;
  } while (scratch.rest > 0);
  EXPECT_EQ(done, SpatialIndex::kGroupPoints);
  EXPECT_GT(runs, 1u);
}

}  // namespace
}  // namespace curvd::testing
