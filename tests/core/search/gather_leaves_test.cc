// The lists of leaves around a box, on each instruction set that this machine has.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/core/search/gather_leaves_test.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/search/gather_leaves-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

bool CallGatherLeaves(const SpatialIndex& index, const Box& box, float squared_reach, size_t max_leaves,
                      LeafList& leaves) {
  uint64_t work = 0;
  return GatherLeaves(index, box, squared_reach, max_leaves, leaves, work);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <gtest/gtest.h>

#include "tests/core/instruction_sets.h"
#include "tests/core/test_clouds.h"

namespace curvd {
HWY_EXPORT(CallGatherLeaves);

namespace testing {
namespace {

class GatherLeavesTest : public InstructionSetTest {
 protected:
  static bool Gather(const SpatialIndex& index, const Box& box, float squared_reach, size_t max_leaves,
                     LeafList& leaves) {
    return HWY_DYNAMIC_DISPATCH(CallGatherLeaves)(index, box, squared_reach, max_leaves, leaves);
  }
};

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, GatherLeavesTest, InstructionSets(), InstructionSetName);

// Points of a leaf within a squared distance of a box that has no extent.
bool AnyPointNear(const SpatialIndex& index, size_t leaf, const float* center, float squared_reach) {
  const SpatialIndex::LeafPositions& points = index.positions(leaf);
  for (int i = 0; i < index.LeafPoints(leaf); ++i) {
    const float x = points.x[i] - center[0], y = points.y[i] - center[1], z = points.z[i] - center[2];
    if ((x * x + y * y) + z * z <= squared_reach) return true;
  }
  return false;
}

TEST_P(GatherLeavesTest, ListsEveryLeafWithAPointInReachInTreeOrder) {
  // Clouds of few points reach each shape of the last group.
  for (const size_t points : {3, 17, 40, 64, 65, 90, 120, 1000, 5000}) {
    const SpatialIndex index = BuildIndex(RandomPoints(Layout::kUniform, points, points).ToCloud());
    const SpatialIndex::LeafPositions& first = index.positions(0);
    const float center[3] = {first.x[0], first.y[0], first.z[0]};
    const Box box = {{center[0], center[1], center[2]}, {center[0], center[1], center[2]}};
    for (const float squared_reach : {0.0f, 0.001f, 0.01f, 0.1f, 4.0f}) {
      LeafList list;
      ASSERT_TRUE(Gather(index, box, squared_reach, index.leaf_count(), list));
      size_t next = 0;
      for (size_t leaf = 0; leaf < index.leaf_count(); ++leaf) {
        if (next < list.size() && list.leaf(next) == leaf) {
          ++next;
        } else {
          EXPECT_FALSE(AnyPointNear(index, leaf, center, squared_reach)) << points << " points, leaf " << leaf;
        }
      }
      EXPECT_EQ(next, list.size());  // in order, each once
      for (size_t i = list.size(); i < list.padded_size(); ++i) EXPECT_GT(list.lo(0)[i], 1e30f);
      if (squared_reach >= 4.0f) {
        EXPECT_EQ(list.size(), index.leaf_count());
      }
    }
  }
}

TEST_P(GatherLeavesTest, LeavesOutWhatIsFarAndStopsAtTheLimit) {
  const SpatialIndex index = BuildIndex(RandomPoints(Layout::kUniform, 5000, 9).ToCloud());
  const Box box = {{0.2f, 0.2f, 0.2f}, {0.3f, 0.3f, 0.3f}};
  LeafList list;
  ASSERT_TRUE(Gather(index, box, 0.01f, index.leaf_count(), list));
  ASSERT_GT(list.size(), 0u);
  EXPECT_LT(list.size(), index.leaf_count() / 2);
  EXPECT_FALSE(Gather(index, box, 0.01f, list.size() - 1, list));
}

}  // namespace
}  // namespace testing
}  // namespace curvd

#endif  // HWY_ONCE
