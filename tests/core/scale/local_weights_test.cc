#include "core/scale/local_weights.h"

#include <gtest/gtest.h>

#include <algorithm>
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
  sampled.choice.mean.cloud_weights = {0.6, 0.4};
  sampled.choice.gaussian.cloud_weights = {0.3, 0.7};
  sampled.choice.mean.trends = {{0.5, 0.6, 1.0}, {0.7, 0.4, 0.5}};
  sampled.choice.gaussian.trends = {{0.1, 0.6, 0.0}, {0.2, 0.4, 1.0}};
  for (size_t i = 0; i < count; ++i) {
    sampled.table.emplace_back(std::array<float, 3>{coordinate(random), coordinate(random), coordinate(random)});
    for (ScaleWeights* const weights : {&sampled.choice.mean, &sampled.choice.gaussian}) {
      weights->local_differences.push_back({0.1f + coordinate(random), 0.1f + coordinate(random)});
    }
  }
  return sampled;
}

// By looking at all sampled points.
LocalWeights::Weights SlowWeights(const Sampled& sampled, const ScaleWeights& of, const std::array<float, 3>& at) {
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
  LocalWeights::Weights weights{};
  for (size_t c = 0; c < 2; ++c) {
    double sum = 0.0;
    for (const auto& [squared, i] : order) sum += of.local_differences[i][c];
    weights[c] = ScaleWeight(of.trends[c].ErrorAt(sum / static_cast<double>(order.size())));
  }
  return weights;
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
        const LocalWeights::Weights mean = SlowWeights(sampled, sampled.choice.mean, at);
        const LocalWeights::Weights gaussian = SlowWeights(sampled, sampled.choice.gaussian, at);
        for (size_t c = 0; c < 2; ++c) {
          EXPECT_NEAR(found.mean[c] / mean[c], 1.0, 1e-9) << count;
          EXPECT_NEAR(found.gaussian[c] / gaussian[c], 1.0, 1e-9) << count;
        }
      }
    }
  }
}

TEST(LocalWeightsTest, AChoiceForTheWholeCloudIsTheSameEverywhere) {
  Sampled sampled = RandomSamples(100);
  sampled.choice.mean.trends.clear();
  sampled.choice.gaussian.trends.clear();
  LocalWeights weights(sampled.table, sampled.choice);
  weights.Start({{0, 0, 0}, {1, 1, 1}});
  const float at[3] = {0.5f, 0.5f, 0.5f};
  EXPECT_EQ(weights.At(at).mean[0], 0.6);
  EXPECT_EQ(weights.At(at).mean[1], 0.4);
  EXPECT_EQ(weights.At(at).gaussian[1], 0.7);
}

}  // namespace
}  // namespace curvd::testing
