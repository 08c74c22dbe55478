#include "core/estimators/delaunay/umbrella_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "core/estimators/triangles/random_stream.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

constexpr size_t kLeaf = SpatialIndex::kLeafSize;

using PlaceTriangle = std::array<uint32_t, 3>;

// The triangles of a list of leaves, as they are gathered, and by comparing each corner's leaf with all of the list.
class UmbrellaTrianglesTest : public ::testing::Test {
 protected:
  UmbrellaTrianglesTest() : index_(BuildIndex(Sphere(100'000, 1.0).ToCloud())) {}

  // Umbrellas of full rims whose corners lie in the listed leaves, or in ones near those.
  void MakeUmbrellas(const std::vector<uint32_t>& listed) {
    umbrellas_.assign(index_.leaf_count() * kLeaf, {});
    RandomStream random(1, listed.size());
    for (const uint32_t leaf : listed) {
      for (size_t lane = 0; lane < kLeaf; ++lane) {
        Umbrella& umbrella = umbrellas_[leaf * kLeaf + lane];
        for (int32_t& corner : umbrella.rim) {
          const uint32_t near = listed[random.Next() % listed.size()] + static_cast<uint32_t>(random.Next() % 3);
          const size_t place = std::min<size_t>(near, index_.leaf_count() - 2) * kLeaf + random.Next() % kLeaf;
          corner = static_cast<int32_t>(place);
        }
        umbrella.occurrences = 0x05555555;  // each of 14 triangles once
      }
    }
  }

  void ExpectAllTriangles(const std::vector<uint32_t>& listed) {
    MakeUmbrellas(listed);
    LeafList leaves;
    for (const uint32_t leaf : listed) leaves.Add(index_, leaf);
    leaves.Pad();
    UmbrellaTriangles triangles;
    ASSERT_TRUE(triangles.Gather(index_, umbrellas_.data(), leaves));
    std::vector<PlaceTriangle> expected, actual;
    for (const uint32_t leaf : listed) {
      for (size_t lane = 0; lane < kLeaf; ++lane) AddExpected(listed, leaf * kLeaf + lane, expected);
    }
    for (size_t t = 0; t < triangles.size(); ++t) {
      const uint32_t* place = triangles.triangle(t).place;
      actual.push_back({place[0], place[1], place[2]});
    }
    EXPECT_EQ(actual, expected);
    EXPECT_EQ(triangles.lookups(), 2 * kLeaf * Umbrella::kMaxTriangles * listed.size());
  }

  const SpatialIndex index_;

 private:
  void AddExpected(const std::vector<uint32_t>& listed, size_t tree_place, std::vector<PlaceTriangle>& expected) const {
    const auto place_of = [&](size_t place) {
      const auto found = std::ranges::find(listed, static_cast<uint32_t>(place / kLeaf));
      return static_cast<uint32_t>((found - listed.begin()) * kLeaf + place % kLeaf);
    };
    const auto is_listed = [&](int32_t place) {
      return std::ranges::count(listed, static_cast<uint32_t>(place) / kLeaf) > 0;
    };
    const int32_t* rim = umbrellas_[tree_place].rim;
    for (int i = 0; i < Umbrella::kMaxTriangles; ++i) {
      if (!is_listed(rim[i]) || !is_listed(rim[i + 1])) continue;
      expected.push_back(
          {place_of(tree_place), place_of(static_cast<size_t>(rim[i])), place_of(static_cast<size_t>(rim[i + 1]))});
    }
  }

  std::vector<Umbrella> umbrellas_;
};

TEST_F(UmbrellaTrianglesTest, FindsTheCornersInLeavesInARow) {
  std::vector<uint32_t> listed(200);
  for (uint32_t i = 0; i < listed.size(); ++i) listed[i] = 17 + i;
  ExpectAllTriangles(listed);
}

// Forty leaves get a table of 128 slots, and every 128th leaf the same one of them.
TEST_F(UmbrellaTrianglesTest, FindsTheCornersInLeavesThatWantTheSameSlots) {
  std::vector<uint32_t> listed;
  for (uint32_t i = 0; i < 40; ++i) listed.push_back(3 + 128 * i);
  ExpectAllTriangles(listed);
  listed.clear();
  for (uint32_t i = 0; i < 12; ++i) {
    for (uint32_t row = 0; row < 5; ++row) listed.push_back(3 + 256 * i + row);
  }
  ExpectAllTriangles(listed);
}

TEST_F(UmbrellaTrianglesTest, MakesTheTrianglesOfAListOnce) {
  LeafList leaves;
  leaves.Add(index_, 0);
  leaves.Pad();
  const std::vector<Umbrella> none(index_.leaf_count() * kLeaf, Umbrella{});
  UmbrellaTriangles triangles;
  EXPECT_TRUE(triangles.Gather(index_, none.data(), leaves));
  EXPECT_FALSE(triangles.Gather(index_, none.data(), leaves));
  leaves.Pad();
  EXPECT_TRUE(triangles.Gather(index_, none.data(), leaves));
  EXPECT_EQ(triangles.size(), 0u);
}

}  // namespace
}  // namespace curvd::testing
