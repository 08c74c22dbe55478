#include "core/scale/pilot/neighbor_copies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "core/scale/pilot/distance_order.h"

namespace curvd::testing {
namespace {

using Offset = std::array<float, 3>;

// The ids of neighbors at these offsets once copies are marked; that of each is `ids` at its place, or its place.
std::vector<int32_t> MarkedIds(const std::vector<Offset>& offsets, std::vector<int32_t> ids = {}) {
  if (ids.empty()) {
    ids.resize(offsets.size());
    std::iota(ids.begin(), ids.end(), 0);
  }
  PilotScratch s;
  s.neighbors.Reserve(offsets.size());
  s.ids.Reserve(offsets.size());
  s.neighbors.count = offsets.size();
  for (size_t i = 0; i < offsets.size(); ++i) {
    const auto& [x, y, z] = offsets[i];
    s.neighbors.dx[i] = x;
    s.neighbors.dy[i] = y;
    s.neighbors.dz[i] = z;
    s.ids[i] = ids[i];
  }
  OrderByDistance(s);
  MarkCopies(s);
  for (size_t i = 0; i < ids.size(); ++i) ids[i] = s.ids[i];
  return ids;
}

// At random over a disk of radius 1.
std::vector<Offset> OffsetsOnDisk(size_t count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> coordinate(-1.0f, 1.0f);
  std::vector<Offset> offsets;
  while (offsets.size() < count) {
    const Offset offset = {coordinate(random), coordinate(random), 0.0f};
    if (std::hypot(offset[0], offset[1]) < 1.0f) offsets.push_back(offset);
  }
  return offsets;
}

size_t CountOfCopies(const std::vector<int32_t>& ids) {
  return static_cast<size_t>(std::count_if(ids.begin(), ids.end(), IsCopy));
}

TEST(NeighborCopiesTest, ComplementsTellTheFirst) {
  for (const int32_t id : {0, 1, 1'000'000}) {
    EXPECT_FALSE(IsCopy(id));
    EXPECT_TRUE(IsCopy(~id));
    EXPECT_EQ(FirstOfCopies(id), id);
    EXPECT_EQ(FirstOfCopies(~id), id);
  }
}

TEST(NeighborCopiesTest, OfExactCopiesTheLowestIdIsFirst) {
  const Offset here = {0.5f, 0.25f, 0.0f}, point = {0.0f, 0.0f, 0.0f};
  // In whatever order they come.
  std::vector<int32_t> ids = {9, 4, 7, 0};
  std::sort(ids.begin(), ids.end());
  do {
    const std::vector<int32_t> marked = MarkedIds({here, here, here, point}, ids);
    const int32_t first = *std::min_element(ids.begin(), ids.begin() + 3);
    for (size_t i = 0; i < 3; ++i) EXPECT_EQ(marked[i], ids[i] == first ? first : ~first);
    EXPECT_EQ(marked[3], ids[3]);
  } while (std::next_permutation(ids.begin(), ids.end()));
}

TEST(NeighborCopiesTest, OtherPlacesAtTheSameDistanceAreNoCopies) {
  const Offset right = {1.0f, 0.0f, 0.0f}, left = {-1.0f, 0.0f, 0.0f}, above = {0.0f, 0.0f, 1.0f};
  EXPECT_EQ(MarkedIds({right, left, above}), (std::vector<int32_t>{0, 1, 2}));
  // Each place has its own first one.
  EXPECT_EQ(MarkedIds({right, left, left, above, right, left}, {5, 1, 3, 2, 4, 0}),
            (std::vector<int32_t>{~4, ~0, ~0, 2, 4, 0}));
}

TEST(NeighborCopiesTest, CopiesOfThePointItselfAreFound) {
  const Offset point = {0.0f, 0.0f, 0.0f}, other = {1.0f, 0.0f, 0.0f};
  EXPECT_EQ(MarkedIds({other, point, point}), (std::vector<int32_t>{0, 1, ~1}));
  EXPECT_TRUE(MarkedIds({}).empty());
  EXPECT_EQ(CountOfCopies(MarkedIds({point, point, point})), 2u);
}

// Their mean distance is 0.1, of which copies are within a 256th.
TEST(NeighborCopiesTest, NearCopiesAreFoundWhereTheyAreMany) {
  constexpr size_t kNeighbors = 256, kTwice = 26, kBeside = 5;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::vector<Offset> offsets = OffsetsOnDisk(kNeighbors, seed);
    EXPECT_EQ(CountOfCopies(MarkedIds(offsets)), 0u) << seed;
    for (size_t i = 0; i < kTwice; ++i) {
      offsets.push_back({offsets[i][0] + 1e-5f, offsets[i][1], offsets[i][2]});
    }
    // A hundredth of the mean distance apart, these are other points.
    for (size_t i = kTwice; i < kTwice + kBeside; ++i) {
      offsets.push_back({offsets[i][0] + 1e-3f, offsets[i][1], offsets[i][2]});
    }
    const std::vector<int32_t> ids = MarkedIds(offsets);
    EXPECT_EQ(CountOfCopies(ids), kTwice) << seed;
    // The first one is the nearer one, of equally far ones the one with the lower id.
    const auto squared = [&](size_t i) { return offsets[i][0] * offsets[i][0] + offsets[i][1] * offsets[i][1]; };
    for (size_t i = 0; i < kTwice; ++i) {
      const size_t of_copy = kNeighbors + i;
      const bool is_nearer = squared(i) <= squared(of_copy);
      const size_t first = is_nearer ? i : of_copy, second = is_nearer ? of_copy : i;
      EXPECT_EQ(ids[first], static_cast<int32_t>(first)) << seed;
      EXPECT_EQ(ids[second], ~static_cast<int32_t>(first)) << seed;
    }
  }
}

// Three of 256 may be near each other by chance.
TEST(NeighborCopiesTest, FewNearOnesAreLeftToChance) {
  std::vector<Offset> offsets = OffsetsOnDisk(256, 1);
  for (size_t i = 0; i < 3; ++i) offsets.push_back({offsets[i][0] + 1e-5f, offsets[i][1], offsets[i][2]});
  EXPECT_EQ(CountOfCopies(MarkedIds(offsets)), 0u);
}

// As where a scan was merged with itself, and with one that was moved there and back.
TEST(NeighborCopiesTest, NearCopiesOfExactOnesHaveTheSameFirst) {
  constexpr size_t kNeighbors = 60;
  std::vector<Offset> offsets = OffsetsOnDisk(kNeighbors, 2);
  const std::vector<Offset> once = offsets;
  offsets.insert(offsets.end(), once.begin(), once.end());
  for (const Offset& offset : once) {
    offsets.push_back({offset[0] * (1.0f + 1e-5f), offset[1] * (1.0f + 1e-5f), 0.0f});  // a little farther away
  }
  const std::vector<int32_t> ids = MarkedIds(offsets);
  for (size_t i = 0; i < kNeighbors; ++i) {
    const auto first = static_cast<int32_t>(i);
    EXPECT_EQ(ids[i], first);
    EXPECT_EQ(ids[kNeighbors + i], ~first);
    EXPECT_EQ(ids[2 * kNeighbors + i], ~first);
  }
}

// Points of a scan line are far nearer to each other than lines are, all alike.
TEST(NeighborCopiesTest, ExactCopiesOfANearOneHaveTheSameFirst) {
  constexpr size_t kPlaces = 60;
  constexpr float kNearer = 1.0f - 1e-5f;
  std::vector<Offset> offsets;
  for (const Offset& place : OffsetsOnDisk(kPlaces, 3)) {
    offsets.push_back(place);
    offsets.push_back(place);
    offsets.push_back({kNearer * place[0], kNearer * place[1], 0.0f});
  }
  const std::vector<int32_t> marked = MarkedIds(offsets);
  for (size_t i = 0; i < offsets.size(); i += 3) {
    EXPECT_FALSE(IsCopy(marked[i + 2])) << "the nearest to the point";
    EXPECT_EQ(marked[i], ~marked[i + 2]);
    EXPECT_EQ(marked[i + 1], ~marked[i + 2]);
  }
}

TEST(NeighborCopiesTest, PointsOfALineAreNoCopies) {
  std::vector<Offset> offsets;
  for (const float y : {-0.5f, 0.0f, 0.5f}) {
    for (int i = -400; i <= 400; ++i) offsets.push_back({static_cast<float>(i) / 400.0f, y, 0.0f});
  }
  EXPECT_EQ(CountOfCopies(MarkedIds(offsets)), 0u);
}

}  // namespace
}  // namespace curvd::testing
