#include "core/estimators/strategies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/estimators/fits/jet_systems.h"
#include "core/estimators/group_scratch.h"
#include "core/estimators/option_specs.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// Runs all groups on one scratch, as one worker would; returns the bytes that it holds afterwards.
absl::StatusOr<size_t> RunOnOneWorker(const Strategy& strategy, const EstimatorOptions& options,
                                      const SpatialIndex& index) {
  std::vector<PointCurvature> results(index.point_count());
  const std::unique_ptr<StrategyRun> run = strategy.start(options, index, results.data());
  const std::unique_ptr<WorkerScratch> scratch = run->MakeScratch();
  for (const GroupPhase& phase : run->Phases()) {
    const absl::StatusOr<bool> is_needed = phase.Begin();
    if (!is_needed.ok()) return is_needed.status();
    if (!*is_needed) continue;
    for (size_t group = 0; group < index.group_count(); ++group) {
      const absl::Status status = phase.run(group, *scratch);
      EXPECT_LE(scratch->bytes(), strategy.scratch_bytes(options, index.point_count())) << strategy.name;
      if (!status.ok()) return status;
    }
  }
  return scratch->bytes();
}

std::vector<EstimatorOptions> ByCountAndByRadius() {
  std::vector<EstimatorOptions> all;
  for (const uint32_t count : {4u, 50u, 400u}) all.push_back({.neighborhood = NeighborCount{count}});
  for (const double radius : {0.02, 0.3, 100.0}) {
    for (const uint32_t limit : {30u, 10'000u}) {
      all.push_back({.neighborhood = NeighborRadius{radius}, .max_neighbor_count = limit});
    }
  }
  return all;
}

TEST(StrategiesTest, ScratchNeverHoldsMoreThanItsBound) {
  for (const Layout layout : kLayouts) {
    const SpatialIndex index = BuildIndex(RandomPoints(layout, 2000, 5).ToCloud());
    for (const Strategy* strategy : Strategies()) {
      for (EstimatorOptions& options : ByCountAndByRadius()) {
        SCOPED_TRACE(LayoutName(layout));
        options.estimator = strategy->name;
        options.jet_degree = kMaxFittedDegree;
        options.rotation_count = 4;
        (void)RunOnOneWorker(*strategy, options, index);
      }
    }
  }
}

TEST(StrategiesTest, AGroupThatWantsNothingLeavesWhatSearchesHaveLearned) {
  // A sheet of which one side gets results: groups of the other hold halo alone.
  const TestPoints points = RandomPoints(Layout::kCoplanar, 4'000, 3);
  std::vector<uint64_t> ids;
  std::vector<PointRole> roles;
  for (size_t i = 0; i < points.size(); ++i) {
    ids.push_back(i);
    roles.push_back(points.positions[i][0] < 0.25f ? PointRole::kQuery : PointRole::kHalo);
  }
  const auto bytes = [](const std::vector<std::array<float, 3>>& triples) {
    return std::string_view(reinterpret_cast<const char*>(triples.data()), triples.size() * sizeof(triples[0]));
  };
  Cloud cloud;
  ASSERT_TRUE(cloud.AppendPart(bytes(points.positions), bytes(points.normals), ids, roles).ok());
  ASSERT_TRUE(cloud.Finish().ok());
  const SpatialIndex index = BuildIndex(std::move(cloud));
  for (const Strategy* strategy : Strategies()) {
    const EstimatorOptions options = {.estimator = strategy->name};
    std::vector<PointCurvature> results(index.point_set().query_count());
    const std::unique_ptr<StrategyRun> run = strategy->start(options, index, results.data());
    const std::unique_ptr<WorkerScratch> scratch = run->MakeScratch();
    size_t without = 0;
    for (const GroupPhase& phase : run->Phases()) {
      ASSERT_TRUE(phase.Begin().value_or(false));
      if (phase.name == "umbrellas") {
        for (size_t group = 0; group < index.group_count(); ++group) ASSERT_TRUE(phase.run(group, *scratch).ok());
        continue;
      }
      const float& hint = static_cast<GroupScratch&>(*scratch).search.reach_hint;
      for (size_t group = 0; group < index.group_count(); ++group) {
        const auto counts = scratch->status_counts;
        const float before = hint;
        ASSERT_TRUE(phase.run(group, *scratch).ok());
        if (counts != scratch->status_counts) {
          EXPECT_GT(hint, 0.0f);
        } else {
          EXPECT_EQ(hint, before);
          ++without;
        }
      }
    }
    EXPECT_GT(without, index.group_count() / 4) << strategy->name;
    EXPECT_LT(without, index.group_count()) << strategy->name;
  }
}

TEST(StrategiesTest, BallOfTheWholeCloudIsGivenUpAtTheLimit) {
  const SpatialIndex index = BuildIndex(Sphere(60'000, 1.0).ToCloud());
  for (const Strategy* strategy : Strategies()) {
    const EstimatorOptions options = {
        .estimator = strategy->name, .neighborhood = NeighborRadius{100.0}, .max_neighbor_count = 100};
    const absl::StatusOr<size_t> bytes = RunOnOneWorker(*strategy, options, index);
    ASSERT_FALSE(bytes.ok());
    EXPECT_EQ(KindOf(bytes.status()), ErrorKind::kNeighborhoodTooLarge) << bytes.status();
    EXPECT_NE(bytes.status().message().find("more than 100 neighbors"), std::string::npos) << bytes.status();
  }
}

TEST(StrategiesTest, ScratchOfTheDefaultNeighborhoodIsSmallForAnyCloud) {
  for (const Strategy* strategy : Strategies()) {
    // Delaunay's bound counts the most triangles that could meet in the leaves of a group.
    const size_t most = strategy->name == "delaunay" ? size_t{8} << 20 : size_t{1} << 20;
    EXPECT_LT(strategy->scratch_bytes({}, 1'000'000'000), most) << strategy->name;
  }
}

TEST(StrategiesTest, NamesAreDistinctAndFound) {
  std::set<std::string_view> names;
  for (const Strategy* strategy : Strategies()) {
    EXPECT_TRUE(names.insert(strategy->name).second) << strategy->name;
    EXPECT_EQ(FindStrategy(strategy->name), strategy);
    EXPECT_NE(StrategyNames().find(strategy->name), std::string::npos);
    EXPECT_FALSE(strategy->summary.empty());
  }
  EXPECT_EQ(FindStrategy("avg_hexagram"), nullptr);
  EXPECT_EQ(Strategies()[0]->name, EstimatorOptions{}.estimator);
}

TEST(StrategiesTest, EveryOptionThatARowNamesExists) {
  for (const Strategy* strategy : Strategies()) {
    for (const OptionName name : strategy->options) {
      EXPECT_TRUE(std::ranges::any_of(OptionSpecs(), [name](const OptionSpec& spec) { return spec.name == name; }))
          << strategy->name << " " << name;
    }
  }
}

}  // namespace
}  // namespace curvd::testing
