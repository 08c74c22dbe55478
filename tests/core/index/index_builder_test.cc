#include "core/index/index_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>
#include <vector>

#include "core/base/stop_sign.h"
#include "core/index/select_nth.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// Checks a node's box and lowest id against the points below it.
TreeNode CheckSubtree(const SpatialIndex& index, size_t node, size_t first_leaf, size_t leaves) {
  TreeNode expected;
  if (leaves == 1) {
    const auto& points = index.positions(first_leaf);
    expected = {{{points.x[0], points.y[0], points.z[0]}, {points.x[0], points.y[0], points.z[0]}}, points.id[0], 0};
    for (int i = 1; i < index.LeafPoints(first_leaf); ++i) {
      const float position[3] = {points.x[i], points.y[i], points.z[i]};
      for (int axis = 0; axis < 3; ++axis) {
        expected.box.lo[axis] = std::min(expected.box.lo[axis], position[axis]);
        expected.box.hi[axis] = std::max(expected.box.hi[axis], position[axis]);
      }
      expected.min_id = std::min(expected.min_id, points.id[i]);
    }
  } else {
    const size_t left_leaves = SpatialIndex::LeftLeaves(leaves);
    expected = CheckSubtree(index, node + 1, first_leaf, left_leaves);
    const TreeNode right =
        CheckSubtree(index, SpatialIndex::RightChild(node, leaves), first_leaf + left_leaves, leaves - left_leaves);
    for (int axis = 0; axis < 3; ++axis) {
      expected.box.lo[axis] = std::min(expected.box.lo[axis], right.box.lo[axis]);
      expected.box.hi[axis] = std::max(expected.box.hi[axis], right.box.hi[axis]);
    }
    expected.min_id = std::min(expected.min_id, right.min_id);
  }
  const TreeNode& actual = index.node(node);
  EXPECT_EQ(actual.box.lo, expected.box.lo);
  EXPECT_EQ(actual.box.hi, expected.box.hi);
  EXPECT_EQ(actual.min_id, expected.min_id);
  return expected;
}

// Checks the tree and that it holds each of `points` once, with its position and normal.
void CheckIndex(const SpatialIndex& index, const TestPoints& points) {
  ASSERT_EQ(index.point_count(), points.size());
  CheckSubtree(index, 0, 0, index.leaf_count());
  const double unit = std::ldexp(1.0, -index.scale_exponent());
  std::set<int> ids;
  for (size_t leaf = 0; leaf < index.leaf_count(); ++leaf) {
    for (int i = 0; i < index.LeafPoints(leaf); ++i) {
      const int id = index.positions(leaf).id[i];
      ids.insert(id);
      ASSERT_EQ(index.positions(leaf).y[i] * unit, points.positions[id][1]);
      ASSERT_NEAR(index.normals(leaf).z[i], points.normals[id][2], 1e-6);
    }
  }
  EXPECT_EQ(ids.size(), points.size());
}

TEST(IndexBuilderTest, HoldsEveryPointOnceUnderTightBoxes) {
  for (Layout layout : kLayouts) {
    for (size_t n : {1, 15, 16, 17, 64, 65, 1000, 3001}) {
      SCOPED_TRACE(LayoutName(layout));
      const TestPoints points = RandomPoints(layout, n, n);
      CheckIndex(BuildIndex(points.ToCloud()), points);
      CheckIndex(BuildIndex(points.ToCloud(TestPoints::Size::kUnknown)), points);
    }
  }
}

template <typename T>
std::string_view BytesOf(const T& object) {
  return {reinterpret_cast<const char*>(&object), sizeof(T)};
}

// The cloud's own array becomes the tree's, or is copied block by block: nobody can tell from the tree.
TEST(IndexBuilderTest, IsTheSameForACloudOfUnknownSize) {
  const TestPoints points = RandomPoints(Layout::kClustered, 3 * Cloud::kBlockPoints - 7, 1);
  const SpatialIndex expected = BuildIndex(points.ToCloud());
  const SpatialIndex unknown = BuildIndex(points.ToCloud(TestPoints::Size::kUnknown));
  CheckIndex(expected, points);
  ASSERT_EQ(unknown.leaf_count(), expected.leaf_count());
  for (size_t leaf = 0; leaf < expected.leaf_count(); ++leaf) {
    ASSERT_EQ(BytesOf(unknown.positions(leaf)), BytesOf(expected.positions(leaf)));
    ASSERT_EQ(BytesOf(unknown.normals(leaf)), BytesOf(expected.normals(leaf)));
  }
}

TEST(IndexBuilderTest, TakesTheRecordsOfAnExpectedCloud) {
  const TestPoints points = RandomPoints(Layout::kUniform, 1000, 1);
  Cloud cloud = points.ToCloud();
  const void* const records = &cloud.record(0);
  IndexBuilder builder(std::move(cloud));
  ASSERT_TRUE(builder.Start().ok());
  EXPECT_EQ(static_cast<const void*>(&builder.Take().positions(0)), records);
}

TEST(IndexBuilderTest, LeavesOutInvalidPoints) {
  TestPoints points = RandomPoints(Layout::kUniform, 1000, 1);
  for (size_t i = 0; i < 1000; i += 3) points.normals[i] = {0, 0, 0};
  for (const auto size : {TestPoints::Size::kExpected, TestPoints::Size::kUnknown}) {
    const SpatialIndex index = BuildIndex(points.ToCloud(size));
    EXPECT_EQ(index.point_count(), 666u);
    CheckSubtree(index, 0, 0, index.leaf_count());
  }
}

TEST(IndexBuilderTest, ScalesByAPowerOfTwoThatBringsTheExtentNearOne) {
  for (double radius : {1e-30, 1e-6, 1.0, 1e6, 1e30}) {
    const SpatialIndex index = BuildIndex(Sphere(500, radius).ToCloud());
    const Box& box = index.node(0).box;
    const float extent = std::max({box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2]});
    EXPECT_GE(extent, 0.5f);
    EXPECT_LT(extent, 1.0f);
  }
}

// A cloud whose far outlier has the records scaled, slice by slice.
TEST(IndexBuilderTest, EndsWithTheSliceAtWhichItIsStopped) {
  TestPoints points = RandomPoints(Layout::kUniform, 3 * Cloud::kBlockPoints, 1);
  points.positions[7][0] = 1e30f;
  // The first slice is the measuring of all points, then come those of the scaling.
  SliceLog log{.stop_before = 2};
  IndexBuilder builder(points.ToCloud(), StopSign(nullptr, &log));
  ASSERT_TRUE(builder.Start().ok());
  std::vector<IndexBuilder::Part> halves;
  builder.Build(builder.root(), [&](const IndexBuilder::Part& half) { halves.push_back(half); });
  EXPECT_EQ(log.records, points.size() + Cloud::kBlockPoints);
  EXPECT_EQ(log.slices, 4u);  // and the end of the scaling, and of the split
  const SpatialIndex unfinished = builder.Take();
  const auto* records = reinterpret_cast<const PointRecord*>(&unfinished.positions(0));
  for (size_t i = 0; i < points.size(); ++i) {
    const bool is_scaled = records[i].position[1] != points.positions[i][1];
    ASSERT_EQ(is_scaled, i < Cloud::kBlockPoints && points.positions[i][1] != 0.0f) << i;
  }
}

TEST(IndexBuilderTest, AsksBeforeEverySliceOfALargePart) {
  const TestPoints points = RandomPoints(Layout::kUniform, 100'000, 1);
  SliceLog log;
  IndexBuilder builder(points.ToCloud(), StopSign(nullptr, &log));
  ASSERT_TRUE(builder.Start().ok());
  builder.Build(builder.root(), [](const IndexBuilder::Part&) {});
  EXPECT_GE(log.records, 2 * points.size());  // measured and partitioned
  EXPECT_LE(log.largest, kSlicedRecords);
}

}  // namespace
}  // namespace curvd::testing
