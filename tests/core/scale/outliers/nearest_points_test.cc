#include "core/scale/outliers/nearest_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/core/instruction_sets.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// A neighbor's squared distance and place.
using FoundNeighbor = std::pair<float, uint32_t>;
// Of each point, by its place.
using FoundNeighbors = std::map<size_t, std::vector<FoundNeighbor>>;

constexpr auto kAllWanted = [](size_t) { return true; };

// What is found of the wanted points of all groups, in as many runs as `most_work` asks for, which are counted.
FoundNeighbors FindAll(const SpatialIndex& index, size_t nearest, uint64_t most_work = WorkerScratch::kMostRunWork,
                       absl::FunctionRef<bool(size_t place)> is_wanted = kAllWanted, size_t* runs = nullptr) {
  FoundNeighbors found;
  NearestScratch scratch;
  scratch.most_work = most_work;
  for (size_t group = 0; group < index.group_count(); ++group) {
    scratch.first_point = 0;
    do {
      scratch.rest = 0;
      const auto visit = [&](size_t i, std::span<const NearestPoint> neighbors) {
        std::vector<FoundNeighbor> listed;
        for (const NearestPoint& neighbor : neighbors) listed.emplace_back(neighbor.squared_distance, neighbor.place);
        EXPECT_TRUE(found.emplace(scratch.points.place[i], listed).second) << "visited twice";
      };
      EXPECT_TRUE(ForEachNearest(index, group, nearest, scratch, is_wanted, visit).ok());
      if (runs != nullptr) ++*runs;
      if (scratch.rest != 0 && scratch.rest <= scratch.first_point) {
        ADD_FAILURE() << "no run would end";
        return found;
      }
      scratch.first_point = scratch.rest;
    } while (scratch.rest > 0);
  }
  return found;
}

// A point of an index, by its place.
struct PlacedPoint {
  float x, y, z;
  int32_t rank;
};

std::vector<PlacedPoint> PlacedPoints(const SpatialIndex& index) {
  std::vector<PlacedPoint> points;
  for (size_t place = 0; place < index.point_count(); ++place) {
    const SpatialIndex::LeafPositions& leaf = index.positions(place / SpatialIndex::kLeafSize);
    const size_t i = place % SpatialIndex::kLeafSize;
    points.push_back({leaf.x[i], leaf.y[i], leaf.z[i], leaf.id[i]});
  }
  return points;
}

// The `nearest` ones and the point itself are the first by distance and rank. These come by distance and place, without
// the point. Distances are added up as the search does it.
std::vector<FoundNeighbor> NearestByBruteForce(const std::vector<PlacedPoint>& points, size_t place, size_t nearest) {
  std::vector<std::tuple<float, int32_t, uint32_t>> all;
  all.reserve(points.size());
  for (size_t other = 0; other < points.size(); ++other) {
    const float x = points[other].x - points[place].x, y = points[other].y - points[place].y,
                z = points[other].z - points[place].z;
    all.emplace_back((x * x + y * y) + z * z, points[other].rank, static_cast<uint32_t>(other));
  }
  const size_t count = std::min(all.size(), nearest + 1);
  std::partial_sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count), all.end());
  all.resize(count);
  std::vector<FoundNeighbor> neighbors;
  for (const auto& [squared, rank, other] : all) {
    if (other != place) neighbors.emplace_back(squared, other);
  }
  std::sort(neighbors.begin(), neighbors.end());
  return neighbors;
}

class NearestPointsTest : public InstructionSetTest {};

TEST_P(NearestPointsTest, AreThoseOfBruteForceTiesIncluded) {
  for (const Layout layout : kLayouts) {
    const SpatialIndex index = BuildIndex(RandomPoints(layout, 300, 7).ToCloud());
    const std::vector<PlacedPoint> points = PlacedPoints(index);
    for (const size_t nearest : {size_t{1}, size_t{12}, NearestScratch::kNearest}) {
      const FoundNeighbors found = FindAll(index, nearest);
      ASSERT_EQ(found.size(), points.size()) << LayoutName(layout);
      for (const auto& [place, neighbors] : found) {
        ASSERT_EQ(neighbors, NearestByBruteForce(points, place, nearest)) << LayoutName(layout) << " " << place;
      }
    }
  }
}

TEST_P(NearestPointsTest, SmallCloudsHaveAllOthers) {
  for (const size_t count : {1u, 2u, 20u, 33u}) {
    const SpatialIndex index = BuildIndex(RandomPoints(Layout::kUniform, count, 3).ToCloud());
    const std::vector<PlacedPoint> points = PlacedPoints(index);
    const FoundNeighbors found = FindAll(index, NearestScratch::kNearest);
    ASSERT_EQ(found.size(), count);
    for (const auto& [place, neighbors] : found) {
      EXPECT_EQ(neighbors.size(), count - 1);
      EXPECT_EQ(neighbors, NearestByBruteForce(points, place, NearestScratch::kNearest));
    }
  }
}

// Among more copies than are looked for those of the lowest ranks are found; nearly all of the others miss themselves.
TEST_P(NearestPointsTest, PointsAmongManyCopiesAreNotTheirOwnNeighbors) {
  constexpr size_t kCopies = 100;
  TestPoints cloud = RandomPoints(Layout::kUniform, 200, 5);
  for (size_t i = 0; i < kCopies; ++i) cloud.Add(0.5, 0.5, 0.5, 0.0, 0.0, 1.0);
  const SpatialIndex index = BuildIndex(cloud.ToCloud());
  const std::vector<PlacedPoint> points = PlacedPoints(index);
  const auto is_copy = [&](size_t place) { return points[place].rank >= 200; };
  size_t missed = 0;
  for (const auto& [place, neighbors] : FindAll(index, NearestScratch::kNearest)) {
    if (!is_copy(place)) {
      ASSERT_EQ(neighbors, NearestByBruteForce(points, place, NearestScratch::kNearest));
      continue;
    }
    missed += points[place].rank >= 200 + static_cast<int32_t>(NearestScratch::kNearest) + 1 ? 1 : 0;
    ASSERT_GE(neighbors.size(), NearestScratch::kNearest);
    for (size_t k = 0; k < neighbors.size(); ++k) {
      EXPECT_EQ(neighbors[k].first, 0.0f);
      EXPECT_NE(neighbors[k].second, place);
      EXPECT_TRUE(is_copy(neighbors[k].second));
      EXPECT_TRUE(k == 0 || neighbors[k - 1].second < neighbors[k].second) << "listed twice, or out of order";
    }
  }
  EXPECT_EQ(missed, kCopies - NearestScratch::kNearest - 1);
}

TEST_P(NearestPointsTest, RunsInPartsFindTheSame) {
  const SpatialIndex index = BuildIndex(RandomPoints(Layout::kClustered, 1'000, 9).ToCloud());
  size_t whole_runs = 0, part_runs = 0;
  const FoundNeighbors whole =
      FindAll(index, NearestScratch::kNearest, WorkerScratch::kMostRunWork, kAllWanted, &whole_runs);
  EXPECT_EQ(whole_runs, index.group_count());
  // A point a run.
  EXPECT_EQ(FindAll(index, NearestScratch::kNearest, 0, kAllWanted, &part_runs), whole);
  EXPECT_EQ(part_runs, index.point_count());
  part_runs = 0;
  EXPECT_EQ(FindAll(index, NearestScratch::kNearest, 5'000, kAllWanted, &part_runs), whole);
  EXPECT_GT(part_runs, index.group_count());
  EXPECT_LT(part_runs, index.point_count());
}

TEST_P(NearestPointsTest, VisitsThoseThatAreWantedAlone) {
  const SpatialIndex index = BuildIndex(RandomPoints(Layout::kUniform, 500, 11).ToCloud());
  const FoundNeighbors all = FindAll(index, 12);
  const auto is_wanted = [](size_t place) { return place % 3 == 1; };
  for (const uint64_t most_work : {uint64_t{0}, WorkerScratch::kMostRunWork}) {
    const FoundNeighbors wanted = FindAll(index, 12, most_work, is_wanted);
    size_t count = 0;
    for (const auto& [place, neighbors] : all) {
      if (!is_wanted(place)) continue;
      ++count;
      ASSERT_TRUE(wanted.contains(place));
      EXPECT_EQ(wanted.at(place), neighbors);
    }
    EXPECT_EQ(wanted.size(), count);
  }
}

TEST_P(NearestPointsTest, EndsOnceNobodyWantsTheResult) {
  const SpatialIndex index = BuildIndex(RandomPoints(Layout::kUniform, 500, 13).ToCloud());
  NearestScratch scratch;
  std::atomic<bool> stopped = false;
  scratch.stopped = &stopped;
  size_t visited = 0;
  const auto visit = [&](size_t, std::span<const NearestPoint>) { stopped = ++visited == 2; };
  EXPECT_FALSE(ForEachNearest(index, 0, 12, scratch, kAllWanted, visit).ok());
  EXPECT_EQ(visited, 2u);
}

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, NearestPointsTest, InstructionSets(), InstructionSetName);

}  // namespace
}  // namespace curvd::testing
