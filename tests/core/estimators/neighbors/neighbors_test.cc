// What visitors of a search take of the neighbors, on each instruction set that this machine has.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/core/estimators/neighbors/neighbors_test.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/neighbors/neighbors-inl.h"
#include "core/search/group_search-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// The normals of the neighbors of a query as both visitors sum them.
void CallSum(const SpatialIndex& index, size_t count, const QueryPoint& query, NeighborArrays& neighbors,
             NormalSums& summed, NormalSums& collected) {
  SearchScratch scratch;
  const SearchPlan plan = SearchPlan::ByCount(count);
  const float* p = query.position;
  const Box box = {{p[0], p[1], p[2]}, {p[0], p[1], p[2]}};
  GroupSearch search(index, plan, box, scratch);
  search.Find(p, NormalSummer(index, query, summed));
  search.Find(p, NeighborCollector(index, query, neighbors, collected));
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/instruction_sets.h"
#include "tests/core/test_clouds.h"

namespace curvd {
HWY_EXPORT(CallSum);

namespace testing {
namespace {

using NeighborsTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, NeighborsTest, InstructionSets(), InstructionSetName);

TEST_P(NeighborsTest, CollectedOnesSumAsTheOthersWhateverTheirNumber) {
  const TestPoints points = Sphere(2000, 1.0);
  const SpatialIndex index = BuildIndex(points.ToCloud());
  QueryPoint query;
  for (int axis = 0; axis < 3; ++axis) {
    query.position[axis] = std::ldexp(points.positions[7][axis], index.scale_exponent());
    query.normal[axis] = points.normals[7][axis];
  }
  NeighborArrays neighbors;
  for (size_t count = 1; count <= 70; ++count) {
    NormalSums summed, collected;
    HWY_DYNAMIC_DISPATCH(CallSum)(index, count, query, neighbors, summed, collected);
    ASSERT_EQ(neighbors.count, count);
    for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(collected.sum[axis], summed.sum[axis]) << count;
    EXPECT_EQ(collected.least_agreement, summed.least_agreement) << count;
    // The padding after the last neighbor has no normal that could be compared.
    EXPECT_GT(collected.least_agreement, 0.5f) << count;
  }
}

}  // namespace
}  // namespace testing
}  // namespace curvd

#endif  // HWY_ONCE
