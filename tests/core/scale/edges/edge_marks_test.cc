#include "core/scale/edges/edge_marks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// Normals as they are across an edge of 90 degrees.
constexpr NormalTrend kEdge{0.25, 0.5, 0.5, 0.0, 0.0};
constexpr NormalTrend kSmooth{0.01, 0.1, 0.01, 0.01, 0.01};

TEST(EdgeMarksTest, DistancesAreThoseOfTheNearestMark) {
  const SpatialIndex index = BuildIndex(RandomPoints(Layout::kUniform, 3000, 5).ToCloud());
  EdgeMarks marks(index);
  std::mt19937_64 random(7);
  std::vector<std::array<float, 3>> edges;
  for (size_t leaf = 0; leaf < index.leaf_count(); ++leaf) {
    for (int i = 0; i < index.LeafPoints(leaf); ++i) {
      const bool is_edge = leaf / SpatialIndex::kGroupLeaves % 5 == 0 && random() % 4 == 0;
      marks.SetTrend(leaf * SpatialIndex::kLeafSize + static_cast<size_t>(i), is_edge ? kEdge : kSmooth);
      if (is_edge)
        edges.push_back({index.positions(leaf).x[i], index.positions(leaf).y[i], index.positions(leaf).z[i]});
    }
  }
  for (size_t group = 0; group < index.group_count(); ++group) marks.MarkGroup(group, 0.0, 0.0);
  marks.Finish();
  EXPECT_EQ(marks.edge_count(), edges.size());
  ASSERT_TRUE(marks.HasEdges());
  std::uniform_real_distribution<float> coordinate(-1.0f, 1.0f);
  for (int trial = 0; trial < 300; ++trial) {
    const float at[3] = {coordinate(random), coordinate(random), coordinate(random)};
    float nearest = 1e30f;
    for (const auto& edge : edges) {
      const float x = edge[0] - at[0], y = edge[1] - at[1], z = edge[2] - at[2];
      nearest = std::min(nearest, x * x + y * y + z * z);
    }
    EXPECT_EQ(marks.SquaredDistance(at, 1e30f), nearest);
    EXPECT_EQ(marks.SquaredDistance(at, 0.5f * nearest), 0.5f * nearest) << "none is nearer";
  }
}

TEST(EdgeMarksTest, SinglePointsAreChance) {
  const SpatialIndex index = BuildIndex(RandomPoints(Layout::kUniform, 1000, 5).ToCloud());
  for (const size_t together : {1u, 3u, 4u, 12u}) {
    EdgeMarks marks(index);
    for (size_t place = 0; place < 1000; ++place) marks.SetTrend(place, place < together ? kEdge : kSmooth);
    for (size_t group = 0; group < index.group_count(); ++group) marks.MarkGroup(group, 0.0, 0.0);
    marks.Finish();
    EXPECT_EQ(marks.HasEdges(), together >= 4) << together;
    EXPECT_EQ(marks.edge_count(), together >= 4 ? together : 0u);
    EXPECT_EQ(marks.rough_count(), together);
  }
}

TEST(EdgeMarksTest, NoiseAndBendsAreNoEdges) {
  const SpatialIndex index = BuildIndex(RandomPoints(Layout::kUniform, 100, 5).ToCloud());
  const auto count = [&](const NormalTrend& trend, double normal_noise, double position_noise) {
    EdgeMarks marks(index);
    for (size_t place = 0; place < 100; ++place) marks.SetTrend(place, trend);
    for (size_t group = 0; group < index.group_count(); ++group) marks.MarkGroup(group, normal_noise, position_noise);
    marks.Finish();
    return marks.edge_count();
  };
  EXPECT_EQ(count(kEdge, 0.0, 0.0), 100u);
  EXPECT_EQ(count(kEdge, 0.1, 0.0), 100u);
  EXPECT_EQ(count(kEdge, 0.2, 0.0), 0u) << "as rough as noise";
  EXPECT_EQ(count(kEdge, 0.0, 0.4), 0u) << "positions move along what turns";
  EXPECT_EQ(count({0.25, 0.5, 0.5, 0.125, 0.06}, 0.0, 0.0), 0u) << "a bend: clusters leave a quarter, and a ninth";
  EXPECT_EQ(count({0.25, 0.5, 0.6, 0.3, 0.0}, 0.0, 0.0), 100u) << "a corner of three faces";
  EXPECT_EQ(count(kSmooth, 0.0, 0.0), 0u);
}

}  // namespace
}  // namespace curvd::testing
