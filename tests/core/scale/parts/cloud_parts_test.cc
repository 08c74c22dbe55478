#include "core/scale/parts/cloud_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "core/scale/parts/cloud_weights.h"

namespace curvd::testing {
namespace {

constexpr size_t kSide = 20;  // samples lie on a square of so many by so many
constexpr size_t kSamples = kSide * kSide;

struct Traits {
  double position_noise = 0.01, normal_noise = 0.02, radius = 0.1;
};

// Samples on the unit square whose traits are those of `traits_at(x, y)`, but for what chance makes of them.
PilotTable TableWith(const std::function<Traits(double x, double y)>& traits_at) {
  std::mt19937_64 random(3);
  std::lognormal_distribution<double> chance(0.0, 0.1);
  PilotTable table;
  for (size_t i = 0; i < kSamples; ++i) {
    const double x = static_cast<double>(i % kSide) / kSide;
    const double y = std::floor(static_cast<double>(i) / kSide) / kSide;
    PilotPoint& point = table.emplace_back(std::array<float, 3>{static_cast<float>(x), static_cast<float>(y), 0.0f});
    const Traits traits = traits_at(x, y);
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      point.residual[rung] = static_cast<float>(traits.position_noise * chance(random));
      point.normal_residual[rung] = static_cast<float>(traits.normal_noise * chance(random));
      point.radius[rung] = static_cast<float>(traits.radius * std::sqrt(kScaleRungs[rung] / 64.0) * chance(random));
    }
  }
  return table;
}

// How many samples have x of at least 0.5 where the second part begins, and none before.
void ExpectHalves(PilotTable table) {
  const size_t second = SplitIntoParts(table);
  EXPECT_EQ(second, kSamples / 2);
  for (size_t i = 0; i < table.size(); ++i) EXPECT_EQ(table[i].position[0] >= 0.5f, i >= second) << i;
}

TEST(CloudPartsTest, HalvesThatDifferInAnyTraitAreParts) {
  ExpectHalves(TableWith([](double x, double) { return Traits{.position_noise = x < 0.5 ? 0.01 : 0.04}; }));
  ExpectHalves(TableWith([](double x, double) { return Traits{.normal_noise = x < 0.5 ? 0.001 : 0.1}; }));
  ExpectHalves(TableWith([](double x, double) { return Traits{.radius = x < 0.5 ? 0.03 : 0.1}; }));
}

TEST(CloudPartsTest, ExactPointsArePartsToo) {
  ExpectHalves(TableWith([](double x, double) { return Traits{.position_noise = x < 0.5 ? 0.0 : 0.04}; }));
}

TEST(CloudPartsTest, LittleDifferencesAreNone) {
  PilotTable table = TableWith([](double x, double) { return Traits{.position_noise = x < 0.5 ? 0.01 : 0.015}; });
  EXPECT_EQ(SplitIntoParts(table), kSamples);
}

TEST(CloudPartsTest, MoreDetailIsNoPart) {
  PilotTable table = TableWith([](double, double) { return Traits{.position_noise = 1e-3}; });
  for (PilotPoint& point : table) {
    if (point.position[0] < 0.5f) continue;
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      point.residual[rung] *= 4.0f * static_cast<float>(std::pow(kScaleRungs[rung] / 64.0, 2.5));
    }
  }
  EXPECT_EQ(SplitIntoParts(table), kSamples);
}

TEST(CloudPartsTest, WhatHasNoRatioIsNoPart) {
  PilotTable coincident = TableWith([](double, double) { return Traits(); });
  PilotTable without_radius = coincident;
  for (PilotPoint& point : coincident) {
    if (point.position[0] > 0.9f) point.radius.fill(0.0f);
  }
  EXPECT_EQ(SplitIntoParts(coincident), kSamples);
  for (PilotPoint& point : without_radius) {
    if (point.position[0] > 0.9f) point.radius.fill(std::numeric_limits<float>::quiet_NaN());
  }
  EXPECT_EQ(SplitIntoParts(without_radius), kSamples);
}

TEST(CloudPartsTest, WhatChangesLittleByLittleHasNoParts) {
  PilotTable table = TableWith([](double x, double) { return Traits{.position_noise = 0.001 * std::pow(100.0, x)}; });
  EXPECT_EQ(SplitIntoParts(table), kSamples);
}

TEST(CloudPartsTest, PointsAmongOthersAreNoPart) {
  PilotTable mixed = TableWith([](double x, double y) {
    const long at = std::lround(x * kSide) + std::lround(y * kSide);
    return Traits{.position_noise = at % 2 == 0 ? 0.01 : 0.1};
  });
  EXPECT_EQ(SplitIntoParts(mixed), kSamples);
  PilotTable line = TableWith([](double x, double) { return Traits{.position_noise = x == 0.5 ? 0.1 : 0.01}; });
  EXPECT_EQ(SplitIntoParts(line), kSamples) << "as beside an edge";
}

TEST(CloudPartsTest, FewWithoutAFitAreWithTheSecondPart) {
  PilotTable table = TableWith([](double x, double) { return Traits{.position_noise = x < 0.5 ? 0.01 : 0.04}; });
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  for (size_t i = 0; i < 8; ++i) table[i * kSide].residual.fill(kNone);
  EXPECT_EQ(SplitIntoParts(table), kSamples / 2 - 8);
  PilotTable most = TableWith([](double x, double) { return Traits{.position_noise = x < 0.5 ? 0.01 : 0.04}; });
  for (PilotPoint& point : most) {
    if (point.position[0] > 0.8f) point.residual.fill(kNone);
  }
  EXPECT_EQ(SplitIntoParts(most), kSamples);
}

TEST(CloudPartsTest, SmallTablesHaveOnePart) {
  PilotTable none;
  EXPECT_EQ(SplitIntoParts(none), 0u);
  const PilotTable halves = TableWith([](double x, double) { return Traits{.radius = x < 0.5 ? 0.03 : 0.1}; });
  PilotTable few(halves.begin(), halves.begin() + 46), enough(halves.begin(), halves.begin() + 100);
  EXPECT_EQ(SplitIntoParts(few), 46u);
  EXPECT_EQ(SplitIntoParts(enough), 50u);
}

TEST(CloudPartsTest, NoiseInAFewPlacesIsSeen) {
  const auto with_noise_at = [](double most_x) {
    PilotTable table = TableWith([](double, double) { return Traits{.position_noise = 1e-9, .normal_noise = 1e-9}; });
    for (PilotPoint& point : table) {
      if (point.position[0] <= most_x) point.residual.fill(0.01f);
    }
    return table;
  };
  EXPECT_FALSE(ShowNoiseInParts(with_noise_at(-1.0)));
  EXPECT_TRUE(ShowNoiseInParts(with_noise_at(0.0)));
  EXPECT_FALSE(ShowNoiseInParts(with_noise_at(1.0)));
  PilotTable detailed = with_noise_at(-1.0);
  for (size_t rung = 0; rung < kRungCount; ++rung) {
    detailed[5].residual[rung] = 1e-3f * static_cast<float>(std::pow(2.0, static_cast<double>(rung)));
  }
  EXPECT_FALSE(ShowNoiseInParts(detailed)) << "detail grows with the neighborhood";
}

ScaleChoice Scales(size_t first_rung, size_t count) {
  ScaleChoice choice;
  for (size_t c = 0; c < count; ++c) choice.chosen.push_back({kHexagramMethod, first_rung + c});
  choice.weights.mean.cloud_weights.assign(count, 0.25);
  choice.weights.traceless.cloud_weights.assign(count, 0.375);
  choice.weights.gaussian.cloud_weights.assign(count, 0.5);
  return choice;
}

TEST(CloudWeightsTest, APlaceHasThoseOfItsPart) {
  PilotTable table = TableWith([](double x, double) { return Traits{.position_noise = x < 0.5 ? 0.01 : 0.04}; });
  const size_t second = SplitIntoParts(table);
  const PilotPoints all = table;
  const CloudChoice choice({{all.first(second), Scales(2, 3)}, {all.subspan(second), Scales(0, 2)}});
  ASSERT_EQ(choice.chosen().size(), 6u);
  EXPECT_EQ(choice.check(), 5u);
  EXPECT_EQ(choice.chosen()[5], (ScaleCandidate{kHexagramMethod, 1})) << "the next to what counts most";
  EXPECT_EQ(choice.first_of(1), 3u);
  CloudWeights weights(choice);
  const CloudWeights::Weights of_first = {0.25, 0.25, 0.25}, of_second = {0.0, 0.0, 0.0, 0.25, 0.25};
  for (const float x : {0.1f, 0.3f, 0.42f, 0.49f, 0.6f, 0.9f}) {
    const std::array<float, 3> place = {x, 0.5f, 0.0f};
    weights.Start({place, place});
    // Beside the border a sample of either is near.
    EXPECT_EQ(weights.PartAt(place.data()), x > 0.45f ? 1u : 0u) << x;
    EXPECT_EQ(weights.At(place.data()).mean, x > 0.45f ? of_second : of_first) << x;
    EXPECT_EQ(weights.At(place.data(), 0).traceless[0], 0.375) << x;
    EXPECT_EQ(weights.At(place.data(), 0).gaussian[0], 0.5) << x;
    // A dozen of samples around reach two rows of them far.
    EXPECT_EQ(weights.IsNearSecond(place.data()), x > 0.35f) << x;
  }
}

TEST(CloudChoiceTest, NothingIsSmallerThanTheSmallestScale) {
  const PilotTable table = TableWith([](double, double) { return Traits{}; });
  const PilotPoints all = table;
  EXPECT_FALSE(CloudChoice({{all.first(200), Scales(0, 3)}, {all.subspan(200), Scales(4, 2)}}).check().has_value());
}

TEST(CloudChoiceTest, ChecksOfDetailFollowAllOthersAndCountNowhere) {
  const PilotTable table = TableWith([](double, double) { return Traits{}; });
  const PilotPoints all = table;
  const ScaleCandidate of_second = {kRegressionMethod, 6};
  const CloudChoice choice(
      {{all.first(200), Scales(2, 3)}, {all.subspan(200), Scales(4, 2), false, DetailCheck{of_second, 0.1}}});
  ASSERT_EQ(choice.chosen().size(), 7u);
  EXPECT_EQ(choice.check(), 5u);
  EXPECT_EQ(choice.detail_check_of(0), 6u) << "where the first part's would be";
  EXPECT_EQ(choice.detail_check_of(1), 6u);
  EXPECT_EQ(choice.chosen()[6], of_second);
  CloudWeights weights(choice);
  const std::array<float, 3> place = {0.5f, 0.9f, 0.0f};
  weights.Start({place, place});
  for (const size_t part : {0, 1}) EXPECT_EQ(weights.At(place.data(), part).mean[6], 0.0);
}

TEST(CloudChoiceTest, OnePartNeedsNoCheck) {
  const PilotTable table = TableWith([](double, double) { return Traits{}; });
  const CloudChoice choice({{table, Scales(2, 3)}});
  EXPECT_EQ(choice.chosen().size(), 3u);
  EXPECT_FALSE(choice.check().has_value());
  CloudWeights weights(choice);
  const std::array<float, 3> place = {0.5f, 0.5f, 0.0f};
  weights.Start({place, place});
  EXPECT_FALSE(weights.IsNearSecond(place.data()));
}

}  // namespace
}  // namespace curvd::testing
