#include "core/scale/scouting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/core/normals/normal_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// A cloud with what a choice holds when its scouts are about to be sampled.
struct Choice {
  explicit Choice(const TestPoints& points, bool is_automatic = true)
      : index(BuildIndex(points.ToCloud())), pilot(index, 2048), edges(index) {
    if (is_automatic) options.estimator = kAutomaticEstimator;
    options.neighborhood = AutomaticScale{};
    table.assign(pilot.sample_count(), PilotPoint::None());
  }

  void SampleScouts() {
    PilotScratch scratch;
    for (size_t group = 0; group < index.group_count(); ++group) {
      EXPECT_TRUE(pilot.SampleGroup(group, Pilot::Samples::kScouts, scratch, table).ok());
    }
  }
  void FindEdges() {
    PilotScratch scratch;
    for (size_t group = 0; group < index.group_count(); ++group) {
      scratch.first_point = 0;
      scratch.most_work = std::numeric_limits<uint64_t>::max();
      EXPECT_TRUE(edges.Measure(group, scratch).ok());
    }
    edges.Sample(0.0);
    for (size_t group = 0; group < index.group_count(); ++group) EXPECT_TRUE(edges.Mark(group, scratch).ok());
    edges.Finish();
  }
  // Rungs at which the first scout has an estimate of avg-hexagram.
  size_t SampledRungs() const {
    const auto scout = std::find_if(table.begin(), table.end(), [](const PilotPoint& p) { return p.is_sampled(); });
    EXPECT_NE(scout, table.end());
    size_t rungs = 0;
    while (rungs < kRungCount && std::isfinite(scout->mean[kHexagramMethod][rungs][PilotPoint::kAll])) ++rungs;
    return rungs;
  }

  EstimatorOptions options;
  const SpatialIndex index;
  Pilot pilot;
  EdgeRun edges;
  PilotTable table;
};

TestPoints NoisySphere(size_t count) {
  TestPoints sphere = Sphere(count, 1.0);
  AddNoise(0.02, 3, sphere);
  return sphere;
}

// The six faces of a cube, of `side` by `side` points each.
TestPoints Cube(int side) {
  TestPoints cube;
  for (size_t axis = 0; axis < 3; ++axis) {
    for (const float sign : {-1.0f, 1.0f}) {
      for (int i = 0; i < side * side; ++i) {
        const auto at = [side](int k) {
          return 2.0f * (static_cast<float>(k) + 0.5f) / static_cast<float>(side) - 1.0f;
        };
        std::array<float, 3> position{}, normal{};
        position[axis] = normal[axis] = sign;
        position[(axis + 1) % 3] = at(i % side);
        position[(axis + 2) % 3] = at(i / side);
        cube.positions.push_back(position);
        cube.normals.push_back(normal);
      }
    }
  }
  return cube;
}

TEST(ScoutingTest, FirstRungsAreEnoughForAnExactCloud) {
  Choice choice(Torus(8000, 5));
  ASSERT_EQ(choice.pilot.most_rungs(), kRungCount);
  Scouting scouting(choice.options, choice.index, choice.pilot, choice.table, &choice.edges);
  choice.SampleScouts();
  EXPECT_EQ(choice.SampledRungs(), 11u);
  EXPECT_FALSE(scouting.LooksAgain());
  choice.FindEdges();
  EXPECT_FALSE(scouting.LooksAgainAtEdges());
  scouting.SpareOthers();
  EXPECT_LE(choice.pilot.rung_count(), 11u);
  EXPECT_EQ(choice.SampledRungs(), choice.pilot.rung_count());
}

TEST(ScoutingTest, NoisyPositionsAreLookedAtAtAllRungs) {
  Choice choice(NoisySphere(8000));
  Scouting scouting(choice.options, choice.index, choice.pilot, choice.table, &choice.edges);
  choice.SampleScouts();
  EXPECT_TRUE(scouting.LooksAgain());
  EXPECT_EQ(choice.pilot.rung_count(), kRungCount);
  EXPECT_TRUE(std::none_of(choice.table.begin(), choice.table.end(), [](const auto& p) { return p.is_sampled(); }));
  choice.SampleScouts();
  EXPECT_EQ(choice.SampledRungs(), kRungCount);
  EXPECT_FALSE(scouting.LooksAgain());
}

TEST(ScoutingTest, ScoutsBesideEdgesAreLookedAtAtAllRungs) {
  Choice choice(Cube(36));
  Scouting scouting(choice.options, choice.index, choice.pilot, choice.table, &choice.edges);
  choice.SampleScouts();
  const bool looked_again = scouting.LooksAgain();
  if (looked_again) choice.SampleScouts();
  choice.FindEdges();
  ASSERT_TRUE(choice.edges.HasEdges());
  EXPECT_NE(scouting.LooksAgainAtEdges(), looked_again);
  EXPECT_FALSE(scouting.LooksAgainAtEdges());
  EXPECT_EQ(choice.pilot.rung_count(), kRungCount);
}

TEST(ScoutingTest, NobodyIsSparedWhereTheChoiceIsNotMade) {
  Choice choice(Torus(8000, 5), false);
  choice.options.neighborhood = NeighborCount{64};
  Scouting scouting(choice.options, choice.index, choice.pilot, choice.table, nullptr);
  choice.SampleScouts();
  EXPECT_FALSE(scouting.LooksAgain());
  EXPECT_FALSE(scouting.LooksAgainAtEdges());
  scouting.SpareOthers();
  EXPECT_EQ(choice.SampledRungs(), kRungCount);
  EXPECT_EQ(choice.pilot.rung_count(), kRungCount);
}

}  // namespace
}  // namespace curvd::testing
