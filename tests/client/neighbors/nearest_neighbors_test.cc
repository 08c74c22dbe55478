#include "client/neighbors/nearest_neighbors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "client/surfaces/random.h"

namespace curv {
namespace {

bool IsNearer(const Neighbor& a, const Neighbor& b) {
  return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance : a.index < b.index;
}

std::vector<Neighbor> BruteForce(const std::vector<Vec3>& positions, uint32_t query, size_t count) {
  std::vector<Neighbor> neighbors;
  for (uint32_t i = 0; i < positions.size(); ++i) {
    const Vec3 offset = positions[i] - positions[query];
    if (i != query) neighbors.push_back({i, Dot(offset, offset)});
  }
  std::sort(neighbors.begin(), neighbors.end(), IsNearer);
  neighbors.resize(std::min(count, neighbors.size()));
  return neighbors;
}

void ExpectBruteForce(const std::vector<Vec3>& positions, int count, int threads) {
  std::vector<std::atomic<int>> visits(positions.size());
  std::atomic<int> wrong = 0;
  ForEachNeighborhood(positions, count, threads, [&](uint32_t i, std::span<const Neighbor> neighbors) {
    ++visits[i];
    const std::vector<Neighbor> expected = BruteForce(positions, i, static_cast<size_t>(count));
    const auto same = [](const Neighbor& a, const Neighbor& b) {
      return a.index == b.index && a.squared_distance == b.squared_distance;
    };
    if (!std::equal(neighbors.begin(), neighbors.end(), expected.begin(), expected.end(), same)) ++wrong;
  });
  EXPECT_EQ(wrong, 0) << count << " neighbors, " << threads << " threads";
  for (const std::atomic<int>& visit : visits) EXPECT_EQ(visit, 1);
}

std::vector<Vec3> RandomPositions(size_t count, double size) {
  const CounterRandom random(1, 0);
  std::vector<Vec3> positions;
  for (uint64_t i = 0; i < count; ++i) {
    positions.push_back(size *
                        Vec3{random.Uniform(3 * i), random.Uniform(3 * i + 1), 0.01 * random.Uniform(3 * i + 2)});
  }
  return positions;
}

TEST(NearestNeighborsTest, MatchesBruteForce) {
  for (const int count : {1, 6, kMaxNeighbors}) ExpectBruteForce(RandomPositions(600, 1.0), count, 1);
}

std::vector<std::vector<uint32_t>> Indices(const std::vector<Vec3>& positions, int count, int threads) {
  std::vector<std::vector<uint32_t>> lists(positions.size());
  ForEachNeighborhood(positions, count, threads, [&](uint32_t i, std::span<const Neighbor> neighbors) {
    for (const Neighbor& neighbor : neighbors) lists[i].push_back(neighbor.index);
  });
  return lists;
}

TEST(NearestNeighborsTest, ThreadsFindTheSame) {
  const std::vector<Vec3> positions = RandomPositions(50'000, 1.0);
  EXPECT_EQ(Indices(positions, 6, 4), Indices(positions, 6, 1));
}

// In a lattice, whose squared distances are exact, most neighborhoods end within a tie.
TEST(NearestNeighborsTest, LowerIndicesWinTies) {
  std::vector<Vec3> lattice;
  for (int i = 0; i < 1000; ++i) lattice.push_back({1.0 * (i * 7 % 10), 1.0 * (i / 10 % 10), 1.0 * (i / 100)});
  for (const int count : {2, 12}) ExpectBruteForce(lattice, count, 2);
}

TEST(NearestNeighborsTest, FindsEqualPositions) {
  std::vector<Vec3> twice = RandomPositions(200, 1.0);
  twice.insert(twice.end(), twice.begin(), twice.end());
  ExpectBruteForce(twice, 5, 2);
}

TEST(NearestNeighborsTest, ManyEqualPositionsAreFast) {
  std::atomic<size_t> found = 0;
  ForEachNeighborhood(std::vector<Vec3>(50'000, {1, 2, 3}), 6, 0, [&](uint32_t i, std::span<const Neighbor> neighbors) {
    for (const Neighbor& neighbor : neighbors) found += neighbor.squared_distance == 0.0 && neighbor.index != i ? 1 : 0;
  });
  EXPECT_EQ(found, 300'000u);
}

TEST(NearestNeighborsTest, FewPositionsHaveFewNeighbors) {
  ExpectBruteForce({}, 6, 0);
  ExpectBruteForce({{1, 2, 3}}, 6, 0);
  ExpectBruteForce({{0, 0, 0}, {0, 0, 2}, {5, 0, 0}}, 6, 0);
}

// The squares of these distances overflow or vanish; the neighbors are right all the same.
TEST(NearestNeighborsTest, SizeDoesNotMatter) {
  const auto found = Indices(RandomPositions(300, 1.0), 5, 1);
  EXPECT_EQ(Indices(RandomPositions(300, std::ldexp(1.0, -1000)), 5, 1), found);
  EXPECT_EQ(Indices(RandomPositions(300, std::ldexp(1.0, 1000)), 5, 1), found);
}

TEST(NearestNeighborsTest, SurvivesTheLargestNumbers) {
  constexpr double kLargest = std::numeric_limits<double>::max();
  std::vector<Vec3> positions;
  for (int i = 0; i < 3000; ++i)
    positions.push_back({kLargest, (1.0 - 1e-4 * i) * kLargest, i % 2 ? kLargest : -kLargest});
  size_t smallest = 6;
  ForEachNeighborhood(positions, 6, 1,
                      [&](uint32_t, std::span<const Neighbor> n) { smallest = std::min(smallest, n.size()); });
  EXPECT_EQ(smallest, 6u);
}

}  // namespace
}  // namespace curv
