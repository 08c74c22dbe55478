#include "core/scale/edges/edge_marks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// Normals as they are across an edge of 90 degrees.
constexpr NormalTrend kEdge{0.25, 0.5};
constexpr NormalTrend kSmooth{0.01, 0.1};
constexpr EdgeNoise kNoNoise{0.0, 0.0};

// Marks rough points, whose normals are all taken to be of faces.
void MarkRough(const SpatialIndex& index, EdgeMarks& marks) {
  for (size_t group = 0; group < index.group_count(); ++group) {
    uint64_t rough = 0;
    for (size_t i = 0; i < SpatialIndex::kGroupPoints; ++i) {
      const size_t place = group * SpatialIndex::kGroupPoints + i;
      if (place >= index.leaf_count() * SpatialIndex::kLeafSize) break;
      if (marks.IsRough(place, kNoNoise)) rough |= uint64_t{1} << i;
    }
    marks.MarkGroup(group, static_cast<size_t>(std::popcount(rough)), rough);
  }
  marks.Finish();
}

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
  MarkRough(index, marks);
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
    MarkRough(index, marks);
    EXPECT_EQ(marks.HasEdges(), together >= 4) << together;
    EXPECT_EQ(marks.edge_count(), together >= 4 ? together : 0u);
    EXPECT_EQ(marks.rough_count(), together);
  }
}

TEST(EdgeMarksTest, WhatIsNearlyRoughMayBe) {
  const SpatialIndex index = BuildIndex(RandomPoints(Layout::kUniform, 100, 5).ToCloud());
  EdgeMarks marks(index);
  constexpr EdgeNoise kNoise{0.1, 0.0};
  const double rough = std::hypot(1.5 * 0.1, 0.06);
  marks.SetTrend(0, {1.01 * rough, 0.0});
  marks.SetTrend(1, {0.9 * rough, 0.0});
  marks.SetTrend(2, {0.8 * rough, 0.0});
  EXPECT_TRUE(marks.IsRough(0, kNoise) && marks.MayBeRough(0, kNoise));
  EXPECT_TRUE(!marks.IsRough(1, kNoise) && marks.MayBeRough(1, kNoise));
  EXPECT_FALSE(marks.MayBeRough(2, kNoise));
  EXPECT_FALSE(marks.MayBeRough(3, kNoise)) << "was not measured";
}

TEST(EdgeMarksTest, NoiseIsNotRough) {
  const SpatialIndex index = BuildIndex(RandomPoints(Layout::kUniform, 100, 5).ToCloud());
  EdgeMarks marks(index);
  marks.SetTrend(0, kEdge);
  marks.SetTrend(1, kSmooth);
  EXPECT_TRUE(marks.IsRough(0, kNoNoise));
  EXPECT_TRUE(marks.IsRough(0, {0.1, 0.0}));
  EXPECT_FALSE(marks.IsRough(0, {0.2, 0.0})) << "as rough as noise";
  EXPECT_FALSE(marks.IsRough(0, {0.0, 0.4})) << "positions move along what turns";
  EXPECT_FALSE(marks.IsRough(1, kNoNoise));
  EXPECT_NEAR(marks.NoiseAt(0, {0.3, 0.8}), 0.5, 1e-6) << "what a slope of 0.5 makes of both";
}

}  // namespace
}  // namespace curvd::testing
