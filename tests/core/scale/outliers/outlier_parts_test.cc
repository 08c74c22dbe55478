// Looks for outliers in parts of groups.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/scale/outliers/outlier_run.h"
#include "tests/core/estimators/run_in_parts.h"
#include "tests/core/scale/outliers/outlier_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// A point a run, and several of them; a group takes about 15,000 steps.
constexpr uint64_t kPartsOfGroup[] = {0, 1'000, 2'000, 5'000, 8'000};

// Those that are found by the pieces of surface that an estimate has left, in the order of the points. No run of a
// group does more than `most_work`.
std::vector<int32_t> OutliersInParts(const SpatialIndex& index, const std::vector<PointCurvature>& pieces,
                                     uint64_t most_work) {
  OutlierRun run(index, pieces.data(), true, OutlierSearch::kFirst);
  RunInParts(run, index, most_work);
  std::vector<int32_t> outliers = run.TakeOutliers();
  std::sort(outliers.begin(), outliers.end());
  return outliers;
}

// How often a group is run until nothing of it is left.
size_t RunsOfFirstGroup(const SpatialIndex& index, uint64_t most_work) {
  NearestScratch scratch;
  scratch.most_work = most_work;
  size_t runs = 0;
  do {
    scratch.rest = 0;
    EXPECT_TRUE(ForEachNearest(
                    index, 0, NearestScratch::kNearest, scratch, [](size_t) { return true; },
                    [](size_t, std::span<const NearestPoint>) {})
                    .ok());
    scratch.first_point = scratch.rest;
    ++runs;
  } while (scratch.rest > 0);
  return runs;
}

// Of a torus with outliers, some of which have copies, and with some flipped normals.
TEST(OutlierPartsTest, FindTheSameAsWholeGroups) {
  for (const double noise : {0.0, 0.3}) {
    TorusWithOutliers cloud = WithOutliersNearby(noise, 300);
    TestPoints& points = cloud.points();
    for (size_t i = kTorusPoints; i < kTorusPoints + 50; ++i) {
      const auto p = points.positions[i], n = points.normals[i];
      for (int copy = 0; copy < 10; ++copy) points.Add(p[0], p[1], p[2], n[0], n[1], n[2]);
    }
    for (size_t i = 0; i < kTorusPoints; i += 500) {
      for (float& component : points.normals[i]) component = -component;
    }
    const EstimationResult estimated = MustEstimate(points.ToCloud(), {.neighborhood = NeighborCount{64}});
    const auto field = estimated.field.points.span();
    const std::vector<PointCurvature> pieces(field.begin(), field.end());
    const SpatialIndex index = BuildIndex(points.ToCloud());
    const std::vector<int32_t> whole = OutliersInParts(index, pieces, WorkerScratch::kNoLimit);
    EXPECT_GT(whole.size(), 300u) << noise;
    ASSERT_EQ(RunsOfFirstGroup(index, WorkerScratch::kNoLimit), 1u);
    for (const uint64_t most_work : kPartsOfGroup) {
      ASSERT_GT(RunsOfFirstGroup(index, most_work), 1u) << most_work;
      EXPECT_EQ(OutliersInParts(index, pieces, most_work), whole) << noise << ", " << most_work;
    }
  }
}

}  // namespace
}  // namespace curvd::testing
