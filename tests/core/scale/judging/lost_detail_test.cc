#include "core/scale/judging/lost_detail.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace curvd::testing {
namespace {

// Of neighborhoods of a point in each unit of area.
std::array<double, kRungCount> RadiiOfRungs() {
  std::array<double, kRungCount> radii;
  for (size_t rung = 0; rung < kRungCount; ++rung) radii[rung] = std::sqrt(kScaleRungs[rung] / std::numbers::pi);
  return radii;
}

// Jets leave squares of these means, of which each point tells one that chance makes larger or smaller, as degrees of
// freedom have it.
template <typename Square>
PilotTable TableOf(const Square& square_at_radius) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  const std::array<double, kRungCount> radii = RadiiOfRungs();
  PilotTable table;
  for (size_t i = 0; i < 512; ++i) {
    PilotPoint point({static_cast<float>(i), 0.0f, 0.0f});
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      const double chance = 1.0 + std::sqrt(2.0 / kScaleRungs[rung]) * normal(random);
      point.radius[rung] = static_cast<float>(radii[rung]);
      point.residual[rung] = static_cast<float>(std::sqrt(square_at_radius(radii[rung]) * std::max(chance, 0.0)));
    }
    table.push_back(point);
  }
  return table;
}

constexpr double kSquaredNoise = 0.01, kSquaredHeight = 0.01;

// Waves are lost within two rungs around the radius of their length.
double LostOf(double wavelength, double radius) {
  return kSquaredHeight / (1.0 + std::pow(wavelength / (1.05 * radius), 12.0));
}

size_t LastRung(size_t most_neighbors) {
  size_t rung = 0;
  while (rung + 1 < kRungCount && kScaleRungs[rung + 1] <= most_neighbors) ++rung;
  return rung;
}

TEST(LostDetailTest, IsTheMeanCurvatureOfTheWavesThatAreLost) {
  for (const double wavelength : {5.0, 8.0, 12.0}) {
    const LostDetail detail(TableOf([&](double radius) { return kSquaredNoise + LostOf(wavelength, radius); }));
    // H is half of the wave number's square times the height.
    const double wave_number = 2.0 * std::numbers::pi / wavelength;
    const double curvature = 0.5 * wave_number * wave_number * std::sqrt(kSquaredHeight);
    const double found = std::sqrt(detail.SquaredBias({kQuarticMethod, kRungCount - 1}));
    EXPECT_NEAR(found / curvature, 1.0, 0.35) << wavelength;
    // Half of the wavelength as radius keeps all of it.
    const size_t small = LastRung(static_cast<size_t>(0.25 * std::numbers::pi * wavelength * wavelength));
    EXPECT_LT(std::sqrt(detail.SquaredBias({kQuarticMethod, small})), 0.2 * curvature) << wavelength;
  }
}

TEST(LostDetailTest, MethodsLoseThemAtScalesOfTheirOwn) {
  const LostDetail detail(TableOf([](double radius) { return kSquaredNoise + LostOf(8.0, radius); }));
  const size_t rung = LastRung(200);
  const auto bias = [&](size_t method, size_t at) { return detail.SquaredBias({method, at}); };
  EXPECT_GT(bias(kQuarticMethod, rung), 0.0);
  for (const size_t method : {kHexagramMethod, kQuadricMethod, kQuadraticRegressionMethod, kSphereMethod}) {
    EXPECT_EQ(bias(method, rung - 2), bias(kQuarticMethod, rung));
  }
  for (const size_t method : {kRegressionMethod, kSexticMethod}) {
    EXPECT_EQ(bias(method, rung + 2), bias(kQuarticMethod, rung));
    EXPECT_EQ(bias(method, 1), 0.0);
  }
}

TEST(LostDetailTest, NeitherNoiseNorSmoothSurfacesHaveAny) {
  const auto last = [](const PilotTable& table) {
    return LostDetail(table).SquaredBias({kQuarticMethod, kRungCount - 1});
  };
  EXPECT_EQ(last(TableOf([](double) { return kSquaredNoise; })), 0.0);
  EXPECT_EQ(last(TableOf([](double radius) { return kSquaredNoise + 1e-11 * std::pow(radius, 10.0); })), 0.0);
  EXPECT_EQ(last(TableOf([](double radius) { return 1e-15 * std::pow(radius, 10.0); })), 0.0) << "exact";
  EXPECT_EQ(last(TableOf([](double radius) { return kSquaredNoise * (1.0 + 1.0 / radius); })), 0.0) << "falls";
  EXPECT_EQ(LostDetail().SquaredBias({kQuarticMethod, kRungCount - 1}), 0.0);
}

// Balls of two standard deviations hold what noise leaves in them, which grows until they hold it all.
TEST(LostDetailTest, NoiseAsLargeAsTheSmallestNeighborhoodsHasNone) {
  const PilotTable table = TableOf([](double radius) { return 4.0 / (1.0 + 16.0 / (radius * radius)); });
  EXPECT_EQ(LostDetail(table).SquaredBias({kQuarticMethod, kRungCount - 1}), 0.0);
}

// A third of the neighborhoods grow into a noisier part.
TEST(LostDetailTest, WhatAFewPointsLoseIsNone) {
  PilotTable table = TableOf([](double) { return kSquaredNoise; });
  const PilotTable others = TableOf([](double radius) { return kSquaredNoise + 4.0 * LostOf(8.0, radius); });
  std::copy_n(others.begin(), table.size() / 3, table.begin());
  EXPECT_EQ(LostDetail(table).SquaredBias({kQuarticMethod, kRungCount - 1}), 0.0);
}

TEST(LostDetailTest, NeedsJetsAtNearlyAllPoints) {
  PilotTable table = TableOf([](double radius) { return kSquaredNoise + LostOf(8.0, radius); });
  EXPECT_GT(LostDetail(table).SquaredBias({kQuarticMethod, kRungCount - 1}), 0.0);
  for (size_t i = 0; i < table.size() / 10; ++i) table[i].residual.fill(PilotPoint::kNone);
  EXPECT_EQ(LostDetail(table).SquaredBias({kQuarticMethod, kRungCount - 1}), 0.0);
}

}  // namespace
}  // namespace curvd::testing
