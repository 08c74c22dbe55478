// Umbrellas against brute force, on each instruction set that this machine has.
#include "core/estimators/delaunay/umbrella.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "core/estimators/group_scratch.h"
#include "tests/core/instruction_sets.h"
#include "tests/core/reference_delaunay.h"
#include "tests/core/sanitized.h"
#include "tests/core/test_clouds.h"
#include "tests/core/umbrella_clouds.h"

namespace curvd::testing {
namespace {

using UmbrellaTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, UmbrellaTest, InstructionSets(), InstructionSetName);

using Triangle = std::array<int, 3>;

struct UmbrellaScratch : GroupScratch {
  size_t bytes() const override { return sizeof(*this) + search.bytes(); }
};

// The umbrellas of a cloud, and the ids of points by place.
struct BuiltUmbrellas {
  explicit BuiltUmbrellas(const TestPoints& points) : index(BuildIndex(points.ToCloud())) {
    umbrellas.resize(index.leaf_count() * SpatialIndex::kLeafSize);
    UmbrellaScratch scratch;
    const SearchPlan plan = UmbrellaSearch(index);
    for (size_t group = 0; group < index.group_count(); ++group) {
      BuildUmbrellas(index, plan, group, scratch, umbrellas.data());
    }
    CountOccurrences(umbrellas.data(), 0, points.size());
  }

  int Id(int32_t place) const {
    return index.positions(place / SpatialIndex::kLeafSize).id[place % SpatialIndex::kLeafSize];
  }
  // (point, corner, corner) of each triangle, by id.
  std::vector<Triangle> Triangles(size_t place) const {
    std::vector<Triangle> triangles;
    const int32_t* rim = umbrellas[place].rim;
    for (int i = 0; i < Umbrella::kMaxTriangles && rim[i + 1] != Umbrella::kNone; ++i) {
      triangles.push_back({Id(static_cast<int32_t>(place)), Id(rim[i]), Id(rim[i + 1])});
    }
    return triangles;
  }

  SpatialIndex index;
  std::vector<Umbrella> umbrellas;
};

TEST_P(UmbrellaTest, HoldsTheTrianglesThatBruteForceFinds) {
  for (uint64_t seed = 0; seed < (kSanitized ? 2 : 6); ++seed) {
    for (const auto& [name, points] : UmbrellaClouds(seed)) {
      const BuiltUmbrellas built(points);
      size_t certain = 0;
      for (size_t place = 0; place < points.size(); ++place) {
        const int id = built.Id(static_cast<int32_t>(place));
        const ReferenceUmbrella reference = BruteForceUmbrella(points, id);
        if (!reference.certain) continue;
        std::vector<Triangle> expected, actual = built.Triangles(place);
        for (const auto& [a, b] : reference.triangles) expected.push_back({id, a, b});
        std::sort(expected.begin(), expected.end());
        std::sort(actual.begin(), actual.end());
        ASSERT_EQ(actual, expected) << name << " seed " << seed << " point " << id;
        ++certain;
      }
      // The collinear layout is off its line by float rounding, which leaves many angles near the doubles' own.
      const size_t least = name == LayoutName(Layout::kCollinear) ? points.size() / 4 : points.size() * 9 / 10;
      EXPECT_GE(certain, least) << name << " seed " << seed;
    }
  }
}

TEST_P(UmbrellaTest, CountsEachTriangleOnceWithItsOccurrences) {
  for (const auto& [name, points] : UmbrellaClouds(7)) {
    const BuiltUmbrellas built(points);
    std::map<Triangle, int> expected, actual;
    for (size_t place = 0; place < points.size(); ++place) {
      const std::vector<Triangle> triangles = built.Triangles(place);
      for (size_t i = 0; i < triangles.size(); ++i) {
        Triangle triangle = triangles[i];
        std::sort(triangle.begin(), triangle.end());
        ++expected[triangle];
        actual[triangle] += built.umbrellas[place].Occurrences(static_cast<int>(i));
      }
    }
    EXPECT_EQ(actual, expected) << name;
  }
}

TEST_P(UmbrellaTest, LatticeIsTriangulatedTheSameByAllItsPoints) {
  for (uint64_t seed = 0; seed < (kSanitized ? 2 : 6); ++seed) {
    const TestPoints points = UmbrellaClouds(seed)[1].points;
    const BuiltUmbrellas built(points);
    std::map<int, size_t> umbrellas_with;  // triangles by occurrences
    for (size_t place = 0; place < points.size(); ++place) {
      for (int i = 0; i < Umbrella::kMaxTriangles; ++i) ++umbrellas_with[built.umbrellas[place].Occurrences(i)];
    }
    EXPECT_EQ(umbrellas_with[1], 0u);
    EXPECT_EQ(umbrellas_with[2], 0u);
    EXPECT_EQ(umbrellas_with[3], 2u * 19 * 19);  // two a cell
  }
}

}  // namespace
}  // namespace curvd::testing
