// Neighborhoods that GroupSearch finds, and the memory that it takes, on each instruction set that this machine has.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/core/search/search_scratch_test.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include <vector>

#include "core/search/group_search-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Lists the ids of the neighbors.
struct IdCollector {
  const SpatialIndex* index;
  std::vector<int32_t>* ids;

  void Start(size_t count) { ids->reserve(count); }
  HWY_INLINE void operator()(const NearPoints& near, FloatMask inside) {
    const int32_t* id = index->positions(near.leaf).id + near.place;
    for (uint64_t bits = BitsFromMask(inside), i = 0; bits != 0; bits >>= 1, ++i) {
      if ((bits & 1) != 0) ids->push_back(id[i]);
    }
  }
  void Finish() {}
};

float CallFind(const SpatialIndex& index, const SearchPlan& plan, const Box& box, const float* query,
               SearchScratch& scratch, std::vector<int32_t>& ids) {
  GroupSearch search(index, plan, box, scratch);
  return search.Find(query, IdCollector{&index, &ids});
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "tests/core/instruction_sets.h"
#include "tests/core/test_clouds.h"

namespace curvd {
HWY_EXPORT(CallFind);

namespace testing {
namespace {

class SearchScratchTest : public InstructionSetTest {
 protected:
  // The neighbors of a point of the index that shares its group with all of them, so that no list serves it; of one
  // that is alone in its group, otherwise.
  float Find(const SpatialIndex& index, const SearchPlan& plan, const float* query, bool alone) {
    Box box = {{query[0], query[1], query[2]}, {query[0], query[1], query[2]}};
    if (!alone) box = index.node(0).box;
    ids_.clear();
    const float found = HWY_DYNAMIC_DISPATCH(CallFind)(index, plan, box, query, scratch_, ids_);
    EXPECT_LE(scratch_.bytes(), SearchScratchBytes(plan, index.point_count()));
    std::ranges::sort(ids_);
    return found;
  }

  SearchScratch scratch_;
  std::vector<int32_t> ids_;
};

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, SearchScratchTest, InstructionSets(), InstructionSetName);

struct Ranked {
  float squared;
  int32_t id;
  bool operator<(const Ranked& other) const { return std::tie(squared, id) < std::tie(other.squared, other.id); }
};

// All points by distance, then id.
std::vector<Ranked> BruteForce(const SpatialIndex& index, const float* query) {
  std::vector<Ranked> all;
  for (size_t leaf = 0; leaf < index.leaf_count(); ++leaf) {
    const SpatialIndex::LeafPositions& points = index.positions(leaf);
    for (int i = 0; i < index.LeafPoints(leaf); ++i) {
      const float x = points.x[i] - query[0], y = points.y[i] - query[1], z = points.z[i] - query[2];
      all.push_back({(x * x + y * y) + z * z, points.id[i]});
    }
  }
  std::ranges::sort(all, std::less<>());
  return all;
}

std::vector<int32_t> FirstIds(const std::vector<Ranked>& ranked, size_t count) {
  std::vector<int32_t> ids;
  for (size_t i = 0; i < count; ++i) ids.push_back(ranked[i].id);
  std::ranges::sort(ids);
  return ids;
}

TEST_P(SearchScratchTest, FindsWhatBruteForceFindsWithASharedListAndWithout) {
  for (const Layout layout : kLayouts) {
    const SpatialIndex index = BuildIndex(RandomPoints(layout, 4000, 11).ToCloud());
    for (const size_t leaf : {size_t{0}, index.leaf_count() / 2}) {
      const SpatialIndex::LeafPositions& points = index.positions(leaf);
      const float query[3] = {points.x[3], points.y[3], points.z[3]};
      const std::vector<Ranked> all = BruteForce(index, query);
      for (const bool alone : {true, false}) {
        SCOPED_TRACE(LayoutName(layout) + (alone ? ", alone" : ", far from its group"));
        for (const size_t k : {1, 7, 64, 300}) {
          EXPECT_EQ(Find(index, SearchPlan::ByCount(k), query, alone), all[k - 1].squared);
          EXPECT_EQ(ids_, FirstIds(all, k)) << k;
        }
        for (const size_t k : {7, 300}) {
          const float squared = all[k].squared;
          const auto inside = static_cast<size_t>(
              std::ranges::count_if(all, [squared](const Ranked& point) { return point.squared <= squared; }));
          EXPECT_EQ(Find(index, SearchPlan::ByRadius(squared, inside), query, alone), squared);
          EXPECT_EQ(ids_, FirstIds(all, inside)) << k;
          EXPECT_LT(Find(index, SearchPlan::ByRadius(squared, inside - 1), query, alone), 0.0f);
          EXPECT_TRUE(ids_.empty());
        }
      }
    }
  }
}

TEST_P(SearchScratchTest, MemoryIsThatOfTheLimitWhateverTheBall) {
  const SpatialIndex index = BuildIndex(RandomPoints(Layout::kUniform, 200'000, 1).ToCloud());
  const SpatialIndex::LeafPositions& points = index.positions(9);
  const float query[3] = {points.x[0], points.y[0], points.z[0]};
  for (const bool alone : {true, false}) {
    EXPECT_LT(Find(index, SearchPlan::ByRadius(4.0f, 100), query, alone), 0.0f);
    EXPECT_LT(scratch_.bytes(), 128u << 10);
  }
}

}  // namespace
}  // namespace testing
}  // namespace curvd

#endif  // HWY_ONCE
