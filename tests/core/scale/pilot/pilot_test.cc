#include "core/scale/pilot/pilot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <utility>

#include "tests/core/instruction_sets.h"
#include "tests/core/normals/normal_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

SpatialIndex IndexOfNoisySphere(size_t points) {
  TestPoints sphere = Sphere(points, 1.0);
  AddNoise(0.02, 3, sphere);
  return BuildIndex(sphere.ToCloud());
}

PilotTable EmptyTable(const Pilot& pilot) { return PilotTable(pilot.sample_count(), PilotPoint::None()); }

void Sample(const Pilot& pilot, Pilot::Samples which, PilotTable& table) {
  PilotScratch scratch;
  for (size_t group = 0; group < pilot.index().group_count(); ++group) {
    EXPECT_TRUE(pilot.SampleGroup(group, which, scratch, table).ok());
  }
}

PilotTable SampleAll(const Pilot& pilot) {
  PilotTable table = EmptyTable(pilot);
  Sample(pilot, Pilot::Samples::kScouts, table);
  Sample(pilot, Pilot::Samples::kOthers, table);
  return table;
}

size_t SampledCount(const PilotTable& table) {
  return static_cast<size_t>(
      std::count_if(table.begin(), table.end(), [](const PilotPoint& point) { return point.is_sampled(); }));
}

class PilotTest : public InstructionSetTest {};

TEST_P(PilotTest, EstimatesTheSameOnEveryInstructionSet) {
  const SpatialIndex index = IndexOfNoisySphere(3000);
  const Pilot pilot(index, 512);
  const PilotTable here = SampleAll(pilot);
  hwy::SetSupportedTargetsForTest(0);
  const PilotTable anywhere = SampleAll(pilot);
  ASSERT_EQ(here.size(), std::min(Pilot::kMostPoints, index.leaf_count()));
  for (size_t i = 0; i < here.size(); ++i) {
    ASSERT_TRUE(here[i].is_sampled());
    EXPECT_EQ(std::memcmp(&here[i].mean, &anywhere[i].mean, sizeof(here[i].mean)), 0) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, PilotTest, InstructionSets(), InstructionSetName);

TEST(PilotSamplesTest, SmallCloudsHaveSeveralPointsOfALeaf) {
  for (const auto& [points, samples] : {std::pair<size_t, size_t>{100, 28}, {500, 128}, {1000, 189}, {3000, 188}}) {
    const SpatialIndex index = IndexOfNoisySphere(points);
    const PilotTable table = SampleAll(Pilot(index, 64));
    EXPECT_EQ(table.size(), samples) << points;
    std::set<std::array<float, 3>> positions;
    for (const PilotPoint& sample : table) {
      EXPECT_TRUE(sample.is_sampled()) << points;
      positions.insert(sample.position);
    }
    EXPECT_EQ(positions.size(), table.size()) << "a point is sampled once, of " << points;
  }
}

TEST(PilotSamplesTest, ScoutsAreAFewAllOverTheCloud) {
  for (const auto& [points, scouts] : {std::pair<size_t, size_t>{500, 128}, {3000, 94}, {20'000, 64}}) {
    const SpatialIndex index = IndexOfNoisySphere(points);
    const Pilot pilot(index, 64);
    PilotTable table = EmptyTable(pilot);
    Sample(pilot, Pilot::Samples::kScouts, table);
    EXPECT_EQ(SampledCount(table), scouts) << points;
    std::set<int> octants;
    for (const PilotPoint& point : table) {
      if (!point.is_sampled()) continue;
      octants.insert(std::signbit(point.position[0]) + 2 * std::signbit(point.position[1]) +
                     4 * std::signbit(point.position[2]));
    }
    EXPECT_EQ(octants.size(), 8u) << points;
  }
}

TEST(PilotSamplesTest, OthersHaveTheEstimatesOfTheRungsThatAreKept) {
  const SpatialIndex index = IndexOfNoisySphere(20'000);
  Pilot pilot(index, 512);
  const PilotTable at_all = SampleAll(pilot);
  PilotTable table = EmptyTable(pilot);
  pilot.SetRungs(3);
  EXPECT_EQ(pilot.rung_count(), 3u);
  Sample(pilot, Pilot::Samples::kOthers, table);
  size_t sampled = 0;
  for (size_t i = 0; i < table.size(); ++i) {
    if (!table[i].is_sampled()) continue;
    ++sampled;
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      const float mean = table[i].mean[kRegressionMethod][rung][PilotPoint::kAll];
      if (rung < 3) {
        // Sums are of the same neighbors, in another unit.
        EXPECT_NEAR(mean, at_all[i].mean[kRegressionMethod][rung][PilotPoint::kAll], 1e-5f * std::abs(mean)) << i;
      } else {
        EXPECT_TRUE(std::isnan(mean)) << i;
      }
    }
  }
  EXPECT_EQ(sampled, pilot.sample_count() - Pilot::kLeastScouts);
}

MethodSet OnlySpheres() {
  MethodSet methods{};
  methods[kSphereMethod] = true;
  return methods;
}

// Those that tell noise stay in any case.
TEST(PilotSamplesTest, MethodsAreDroppedAlone) {
  const SpatialIndex index = IndexOfNoisySphere(3000);
  Pilot pilot(index, 512);
  const PilotTable all = SampleAll(pilot);
  MethodSet kept{};
  kept[kSphereMethod] = kept[kHexagramMethod] = kept[kRegressionMethod] = kept[kQuarticMethod] = true;
  pilot.KeepMethods(OnlySpheres());
  const PilotTable table = SampleAll(pilot);
  size_t dropped = 0;
  for (size_t i = 0; i < table.size(); ++i) {
    for (size_t m = 0; m < kMethodCount; ++m) {
      for (size_t rung = 0; rung < kRungCount; ++rung) {
        const float before = all[i].mean[m][rung][PilotPoint::kAll], mean = table[i].mean[m][rung][PilotPoint::kAll];
        if (kept[m]) {
          EXPECT_TRUE(mean == before || (std::isnan(mean) && std::isnan(before))) << i << " " << m << " " << rung;
        } else {
          EXPECT_TRUE(std::isnan(mean)) << i << " " << rung;
          dropped += std::isfinite(before) ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(dropped, table.size());
}

TEST(PilotSamplesTest, PointsBetweenAreOthersThanTheSampledOnes) {
  // Of 188, of 563 and of 1,250 leaves, of which up to 512 are sampled.
  for (const auto& [points, between] : {std::pair<size_t, size_t>{3000, 0}, {9000, 51}, {20'000, 512}}) {
    const SpatialIndex index = IndexOfNoisySphere(points);
    const Pilot pilot(index, 32);
    const PilotTable sampled = SampleAll(pilot);
    PilotTable table = EmptyTable(pilot);
    Sample(pilot, Pilot::Samples::kBetween, table);
    EXPECT_EQ(pilot.HasBetween(), between > 0) << points;
    EXPECT_EQ(SampledCount(table), between) << points;
    std::set<std::array<float, 3>> positions;
    for (const PilotTable& samples : {sampled, table}) {
      for (const PilotPoint& point : samples) {
        if (point.is_sampled()) positions.insert(point.position);
      }
    }
    EXPECT_EQ(positions.size(), sampled.size() + between) << points;
  }
}

}  // namespace
}  // namespace curvd::testing
