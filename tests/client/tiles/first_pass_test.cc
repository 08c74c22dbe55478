// What a tile finds out by itself: which of its points its halo was too narrow for.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "client/cli/connection.h"
#include "client/cli/tiles/tile_calls.h"
#include "client/cli/tiles/tile_options.h"
#include "client/tiles/tile_work.h"
#include "tests/client/tiles/small_plan.h"

namespace curv {
namespace {

using testing::PlanHills;
using testing::ScratchDirectory;

constexpr size_t kPoints = 6000;

// The bytes of a row of results.
std::string RowOf(const std::vector<Column>& columns, size_t row) {
  std::string bytes;
  for (const Column& column : columns) {
    std::visit(
        [&](const auto& values) { bytes.append(reinterpret_cast<const char*>(&values[row]), sizeof(values[row])); },
        column.values);
  }
  return bytes;
}

// What the first call for a tile answered by the points' ids, and of which points later calls were.
struct Calls {
  std::map<uint64_t, std::string> first;
  std::set<uint64_t> repaired;
  size_t count = 0;
};

TileEstimator Recording(const TileEstimator& estimator, Calls& calls) {
  return [&estimator, &calls](const FloatArrays& cloud, const std::vector<uint32_t>& queries) {
    absl::StatusOr<TileAnswer> answer = estimator(cloud, queries);
    EXPECT_TRUE(answer.ok()) << answer.status();
    for (size_t i = 0; answer.ok() && i < queries.size(); ++i) {
      const uint64_t id = cloud.ids[queries[i]];
      if (calls.count == 0) {
        calls.first[id] = RowOf(answer->columns, i);
      } else {
        calls.repaired.insert(id);
      }
    }
    ++calls.count;
    return answer;
  };
}

// The rows of the whole cloud by the points' ids.
std::vector<std::string> WholeRows(const PointStore& store, const TileEstimator& estimator) {
  TileCloud cloud;
  EXPECT_TRUE(store.Append(0, kPoints, cloud.points).ok());
  std::sort(cloud.points.begin(), cloud.points.end(),
            [](const TilePoint& a, const TilePoint& b) { return a.id < b.id; });
  for (uint32_t i = 0; i < kPoints; ++i) cloud.queries.push_back(i);
  const absl::StatusOr<TileAnswer> answer = estimator(ToFloats(store.plan(), cloud), cloud.queries);
  EXPECT_TRUE(answer.ok()) << answer.status();
  std::vector<std::string> rows;
  for (size_t i = 0; answer.ok() && i < kPoints; ++i) rows.push_back(RowOf(answer->columns, i));
  return rows;
}

struct Case {
  Estimator estimator;
  uint32_t neighbor_count;
};

class FirstPassTest : public ::testing::TestWithParam<Case> {};

TEST_P(FirstPassTest, EveryWrongPointIsFlaggedBeforeItIsRepaired) {
  EstimateOptions options;
  options.estimator = GetParam().estimator;
  options.neighbor_count = GetParam().neighbor_count;
  const absl::StatusOr<TileReach> reach = ReachOf(options);
  ASSERT_TRUE(reach.ok());
  const ScratchDirectory scratch;
  const TilePlan plan = PlanHills(scratch, kPoints, 1500, *reach);
  const absl::StatusOr<PointStore> store = PointStore::Open(plan);
  ASSERT_TRUE(store.ok()) << store.status();
  const absl::StatusOr<std::unique_ptr<Connection>> connection = Connection::Create({}, 1);
  ASSERT_TRUE(connection.ok()) << connection.status();
  const std::stop_token stop;
  const TileEstimator estimator = EstimatorOn(**connection, options, reach->factor, stop);
  const std::vector<std::string> whole = WholeRows(*store, estimator);
  ASSERT_EQ(whole.size(), kPoints);
  for (const double halo_factor : {0.0, 0.5}) {
    size_t wrong = 0, flagged = 0;
    for (size_t tile = 0; tile < plan.tiles.size(); ++tile) {
      Calls calls;
      ASSERT_TRUE(EstimateTile(*store, tile, halo_factor, Recording(estimator, calls)).ok());
      ASSERT_EQ(calls.first.size(), plan.tile(tile).count);
      flagged += calls.repaired.size();
      for (const auto& [id, row] : calls.first) {
        if (row == whole[id]) continue;
        ++wrong;
        EXPECT_TRUE(calls.repaired.contains(id)) << "point " << id << ", halo " << halo_factor;
      }
    }
    // So that there was something to flag, and not everything was.
    if (halo_factor == 0.0) {
      EXPECT_GT(wrong, kPoints / 20);
    }
    EXPECT_GE(flagged, wrong);
    EXPECT_LT(flagged, kPoints * 9 / 10);
  }
}

INSTANTIATE_TEST_SUITE_P(Estimators, FirstPassTest,
                         ::testing::Values(Case{Estimator::kAvgHexagram, 20}, Case{Estimator::kHexagram, 20},
                                           Case{Estimator::kJetFitting, 15},
                                           Case{Estimator::kAlgebraicShapeOperator, 15},
                                           Case{Estimator::kNormalRegression, 25}, Case{Estimator::kUniform, 15},
                                           Case{Estimator::kDelaunay, 31}),
                         [](const auto& one) {
                           std::string name(EstimatorName(one.param.estimator));
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace curv
