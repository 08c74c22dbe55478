#include "core/scale/edges/edge_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/estimators/neighbors/collect.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// Two unit squares that meet at a right angle along the y axis, of `side` by `side` points each.
TestPoints Corner(int side) {
  TestPoints corner;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const auto at = [side](int k) { return (static_cast<float>(k) + 0.5f) / static_cast<float>(side); };
      corner.positions.push_back({-at(i), at(j), 0.0f});
      corner.normals.push_back({0.0f, 0.0f, 1.0f});
      corner.positions.push_back({0.0f, at(j), -at(i)});
      corner.normals.push_back({1.0f, 0.0f, 0.0f});
    }
  }
  return corner;
}

// Measures and marks every group, in runs of at most so many steps, and finishes.
void Look(const SpatialIndex& index, uint64_t most_work, EdgeRun& edges, PilotScratch& scratch) {
  for (size_t group = 0; group < index.group_count(); ++group) {
    scratch.first_point = 0;
    do {
      scratch.most_work = most_work;
      ASSERT_TRUE(edges.Measure(group, scratch).ok());
      scratch.first_point = scratch.rest;
    } while (scratch.rest > 0);
  }
  edges.Sample(0.0);
  for (size_t group = 0; group < index.group_count(); ++group) ASSERT_TRUE(edges.Mark(group, scratch).ok());
  edges.Finish();
}

// Steps of a look at 32 neighbors of every point.
uint64_t WorkOfAll(const SpatialIndex& index) {
  EstimatorOptions options;
  options.neighborhood = NeighborCount{32};
  const NeighborhoodPlan plan = NeighborhoodPlan::Make(options, index);
  PilotScratch scratch;
  for (size_t group = 0; group < index.group_count(); ++group) {
    const auto all = [](size_t) { return true; };
    const auto look = [&](size_t) { scratch.search.work += 16 * scratch.neighbors.count; };
    EXPECT_TRUE(
        CollectNeighbors(index, plan, group, CollectedPoints::kAll, CollectedNormals::kInUse, scratch, all, look).ok());
  }
  return scratch.work();
}

TEST(EdgeRunTest, LooksAtAQuarterOfASmoothCloud) {
  const SpatialIndex index = BuildIndex(Sphere(8000, 1.0).ToCloud());
  EdgeRun edges(index);
  PilotScratch scratch;
  Look(index, WorkerScratch::kMostRunWork, edges, scratch);
  EXPECT_FALSE(edges.HasEdges());
  EXPECT_LT(scratch.work(), WorkOfAll(index) / 3);
}

TEST(EdgeRunTest, FindsEveryPointBesideAnEdge) {
  constexpr int kSide = 40;
  const TestPoints corner = Corner(kSide);
  const SpatialIndex index = BuildIndex(corner.ToCloud());
  EdgeRun edges(index);
  PilotScratch scratch;
  Look(index, WorkerScratch::kMostRunWork, edges, scratch);
  ASSERT_TRUE(edges.HasEdges());
  const float unit = 1.0f / kSide;
  const auto scale = static_cast<float>(std::ldexp(1.0, index.scale_exponent()));
  PilotTable table{PilotPoint({-0.5f * scale, 0.5f * scale, 0.0f})};
  for (size_t rung = 0; rung < kRungCount; ++rung) table.front().radius[rung] = (rung < 3 ? 0.1f : 0.6f) * scale;
  edges.KeepClear(table);
  EXPECT_EQ(table.front().clear_rungs, 3u);
  for (const auto& at : corner.positions) {
    const float position[3] = {at[0] * scale, at[1] * scale, at[2] * scale};
    const float from_edge = std::max(-at[0], -at[2]);
    // Three rows of points to either side have 32 neighbors some of which lie on the other face.
    if (from_edge < 2.0f * unit) {
      EXPECT_EQ(edges.DistanceToEdge(position), 0.0f) << at[0] << " " << at[1] << " " << at[2];
    } else if (from_edge > 5.0f * unit) {
      EXPECT_GT(edges.DistanceToEdge(position), unit * scale);
    }
  }
}

TEST(EdgeRunTest, FindsTheSameInShortRuns) {
  const TestPoints corner = Corner(20);
  const SpatialIndex index = BuildIndex(corner.ToCloud());
  EdgeRun at_once(index), in_parts(index);
  PilotScratch scratch;
  Look(index, WorkerScratch::kMostRunWork, at_once, scratch);
  Look(index, 1, in_parts, scratch);
  EXPECT_EQ(at_once.HasEdges(), in_parts.HasEdges());
  for (const auto& at : corner.positions) {
    EXPECT_EQ(at_once.DistanceToEdge(at.data()), in_parts.DistanceToEdge(at.data()));
  }
}

// Waves along x over a square of `side` by `side` points, so many spacings long, whose steepest slope is 1.
TestPoints Waves(int side, double spacings) {
  TestPoints waves;
  const double k = 2.0 * 3.14159265358979 / spacings;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const float slope = static_cast<float>(std::cos(k * i)), length = std::hypot(slope, 1.0f);
      const float height = static_cast<float>(std::sin(k * i) / k);
      waves.positions.push_back({static_cast<float>(i), static_cast<float>(j), height});
      waves.normals.push_back({-slope / length, 0.0f, 1.0f / length});
    }
  }
  return waves;
}

TEST(EdgeRunTest, NarrowBendsAreNoEdges) {
  for (const double spacings : {6.5, 7.0, 8.0, 10.0}) {
    const SpatialIndex index = BuildIndex(Waves(60, spacings).ToCloud());
    EdgeRun edges(index);
    PilotScratch scratch;
    Look(index, WorkerScratch::kMostRunWork, edges, scratch);
    EXPECT_FALSE(edges.HasEdges()) << spacings;
  }
}

TEST(EdgeRunTest, FindsEdgesOfACloudThatHasNarrowBends) {
  // The waves lie beside the corner, in which no point is farther than 1 from the origin.
  TestPoints both = Corner(40);
  const TestPoints waves = Waves(60, 7.0);
  for (size_t i = 0; i < waves.positions.size(); ++i) {
    const auto& at = waves.positions[i];
    both.positions.push_back({at[0] / 40.0f + 3.0f, at[1] / 40.0f, at[2] / 40.0f});
    both.normals.push_back(waves.normals[i]);
  }
  const SpatialIndex index = BuildIndex(both.ToCloud());
  EdgeRun edges(index);
  PilotScratch scratch;
  Look(index, WorkerScratch::kMostRunWork, edges, scratch);
  EXPECT_TRUE(edges.HasEdges());
}

}  // namespace
}  // namespace curvd::testing
