#include "core/scale/nearest_samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace curvd::testing {
namespace {

PilotTable RandomTable(size_t size) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> coordinate(0.0f, 1.0f);
  PilotTable table;
  for (size_t i = 0; i < size; ++i) table.emplace_back(std::array{coordinate(random), coordinate(random), 0.0f});
  return table;
}

std::vector<uint32_t> BruteForce(const PilotTable& table, const std::array<float, 3>& position, size_t count) {
  std::vector<uint32_t> places(table.size());
  std::iota(places.begin(), places.end(), 0u);
  const auto squared = [&](uint32_t i) {
    const float x = table[i].position[0] - position[0], y = table[i].position[1] - position[1];
    return x * x + y * y;
  };
  std::stable_sort(places.begin(), places.end(), [&](uint32_t a, uint32_t b) { return squared(a) < squared(b); });
  places.resize(std::min(count, places.size()));
  std::sort(places.begin(), places.end());
  return places;
}

TEST(NearestSamplesTest, FindsTheNearestOfAnyPositionInTheBox) {
  const PilotTable table = RandomTable(500);
  NearestSamples samples(table);
  std::mt19937 random(4);
  std::uniform_real_distribution<float> within(0.4f, 0.6f);
  samples.Start({{0.4f, 0.4f, 0.0f}, {0.6f, 0.6f, 0.0f}}, 24);
  for (int i = 0; i < 200; ++i) {
    const std::array position = {within(random), within(random), 0.0f};
    const auto found = samples.At(position.data());
    EXPECT_EQ(std::vector(found.begin(), found.end()), BruteForce(table, position, 24));
  }
  EXPECT_LE(samples.bytes(), NearestSamples::MostBytes(500));
}

TEST(NearestSamplesTest, EqualDistancesGoToTheLowerPlace) {
  PilotTable table;
  for (int i = 0; i < 40; ++i) table.emplace_back(std::array{i % 2 == 0 ? 1.0f : -1.0f, 0.0f, 0.0f});
  table.emplace_back(std::array{0.5f, 0.0f, 0.0f});
  NearestSamples samples(table);
  const float position[3] = {0.0f, 0.0f, 0.0f};
  const auto found = samples.OfAll(position, 6);
  EXPECT_EQ(std::vector(found.begin(), found.end()), (std::vector<uint32_t>{0, 1, 2, 3, 4, 40}));
  const auto all = samples.OfAll(position, 100);
  EXPECT_EQ(all.size(), table.size());
  EXPECT_TRUE(samples.OfAll(position, 0).empty());
}

TEST(NearestSamplesTest, GivesAllWhereThereAreNoMore) {
  const PilotTable table = RandomTable(5), none;
  NearestSamples samples(table), nothing(none);
  const float position[3] = {0.5f, 0.5f, 0.0f};
  const Box box{{0.5f, 0.5f, 0.0f}, {0.5f, 0.5f, 0.0f}};
  samples.Start(box, 24);
  EXPECT_EQ(samples.At(position).size(), 5u);
  nothing.Start(box, 24);
  EXPECT_TRUE(nothing.At(position).empty());
}

}  // namespace
}  // namespace curvd::testing
