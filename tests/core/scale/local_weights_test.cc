#include "core/scale/local_weights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace curvd::testing {
namespace {

struct Sampled {
  PilotTable table;
  ScaleChoice choice;
};

Sampled RandomSamples(size_t count) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<float> coordinate(0.0f, 1.0f);
  Sampled sampled;
  sampled.choice.chosen = {{0, 3}, {1, 5}};
  sampled.choice.weights.mean.cloud_weights = {0.6, 0.4};
  sampled.choice.weights.traceless.cloud_weights = {0.2, 0.8};
  sampled.choice.weights.gaussian.cloud_weights = {0.3, 0.7};
  sampled.choice.weights.mean.trends = {{0.5, 0.6, 1.0}, {0.7, 0.4, 0.5}};
  sampled.choice.weights.traceless.trends = {{0.3, 0.6, 0.5}, {0.4, 0.4, 1.0}};
  sampled.choice.weights.gaussian.trends = {{0.1, 0.6, 0.0}, {0.2, 0.4, 1.0}};
  for (size_t i = 0; i < count; ++i) {
    sampled.table.emplace_back(std::array<float, 3>{coordinate(random), coordinate(random), coordinate(random)});
    auto& [mean, traceless, gaussian] = sampled.choice.weights;
    for (ScaleWeights* const weights : {&mean, &traceless, &gaussian}) {
      weights->local_differences.push_back({0.1f + coordinate(random), 0.1f + coordinate(random)});
    }
  }
  return sampled;
}

// What each is expected to err by, by looking at all sampled points.
LocalWeights::Weights SlowErrors(const Sampled& sampled, const ScaleWeights& of, const std::array<float, 3>& at) {
  std::vector<std::pair<double, size_t>> order;
  for (size_t i = 0; i < sampled.table.size(); ++i) {
    double squared = 0.0;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double d = double{sampled.table[i].position[axis]} - at[axis];
      squared += d * d;
    }
    order.emplace_back(squared, i);
  }
  std::sort(order.begin(), order.end());
  order.resize(std::min(order.size(), ScaleChoice::kNearest));
  LocalWeights::Weights errors{};
  for (size_t c = 0; c < 2; ++c) {
    double sum = 0.0;
    for (const auto& [squared, i] : order) sum += of.local_differences[i][c];
    errors[c] = of.trends[c].ErrorAt(sum / static_cast<double>(order.size()));
  }
  return errors;
}

TEST(LocalWeightsTest, AreThoseOfTheNearestSampledPoints) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<float> coordinate(-0.2f, 1.2f), size(0.0f, 0.3f), within(0.0f, 1.0f);
  for (const size_t count : {1, 10, 24, 25, 400}) {
    const Sampled sampled = RandomSamples(count);
    LocalWeights weights(sampled.table, sampled.choice);
    for (int trial = 0; trial < 50; ++trial) {
      Box box;
      for (size_t axis = 0; axis < 3; ++axis) {
        box.lo[axis] = coordinate(random);
        box.hi[axis] = box.lo[axis] + size(random);
      }
      weights.Start(box);
      for (int i = 0; i < 5; ++i) {
        std::array<float, 3> at;
        for (size_t axis = 0; axis < 3; ++axis)
          at[axis] = box.lo[axis] + within(random) * (box.hi[axis] - box.lo[axis]);
        const LocalWeights::PointWeights found = weights.At(at.data());
        const LocalWeights::Weights mean = SlowErrors(sampled, sampled.choice.weights.mean, at);
        const LocalWeights::Weights traceless = SlowErrors(sampled, sampled.choice.weights.traceless, at);
        const LocalWeights::Weights gaussian = SlowErrors(sampled, sampled.choice.weights.gaussian, at);
        for (size_t c = 0; c < 2; ++c) {
          EXPECT_NEAR(found.mean[c] * std::pow(mean[c], 4), 1.0, 1e-9) << count;
          // What errs in the mean curvature is not trusted with the rest of the shape operator.
          EXPECT_NEAR(found.traceless[c] * std::pow(std::hypot(mean[c], traceless[c]), 4), 1.0, 1e-9) << count;
          EXPECT_NEAR(found.gaussian[c] * std::pow(gaussian[c], 4), 1.0, 1e-9) << count;
        }
      }
    }
  }
}

TEST(LocalWeightsTest, AChoiceForTheWholeCloudIsTheSameEverywhere) {
  Sampled sampled = RandomSamples(100);
  sampled.choice.weights.mean.trends.clear();
  sampled.choice.weights.gaussian.trends.clear();
  LocalWeights weights(sampled.table, sampled.choice);
  weights.Start({{0, 0, 0}, {1, 1, 1}});
  const float at[3] = {0.5f, 0.5f, 0.5f};
  EXPECT_EQ(weights.At(at).mean[0], 0.6);
  EXPECT_EQ(weights.At(at).mean[1], 0.4);
  EXPECT_EQ(weights.At(at).traceless[1], 0.8);
  EXPECT_EQ(weights.At(at).gaussian[1], 0.7);
}

TEST(LocalWeightsTest, TheTracelessPartMayHaveThoseOfTheMeanCurvature) {
  Sampled sampled = RandomSamples(100);
  sampled.choice.weights.traceless = {};
  LocalWeights weights(sampled.table, sampled.choice);
  weights.Start({{0, 0, 0}, {1, 1, 1}});
  const float at[3] = {0.5f, 0.5f, 0.5f};
  EXPECT_EQ(weights.At(at).traceless, weights.At(at).mean);
}

}  // namespace
}  // namespace curvd::testing
