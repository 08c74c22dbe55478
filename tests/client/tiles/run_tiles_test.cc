#include "client/tiles/run_tiles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <stop_token>
#include <thread>
#include <vector>

#include "client/tiles/tile_status.h"
#include "tests/client/tiles/small_plan.h"

namespace curv {
namespace {

using ::testing::ElementsAre;
using testing::PlanHills;
using testing::ScratchDirectory;

class RunTilesTest : public ::testing::Test {
 protected:
  // Answers zeros, and counts calls.
  absl::StatusOr<TileAnswer> Answer(const FloatArrays&, const std::vector<uint32_t>& queries) {
    ++calls_;
    TileAnswer answer;
    answer.columns.push_back({"mean_curvature", std::vector<float>(queries.size())});
    answer.radii.resize(queries.size());
    answer.is_unusable.resize(queries.size());
    return answer;
  }

  TileEstimator Estimator() {
    return [this](const FloatArrays& cloud, const std::vector<uint32_t>& queries) { return Answer(cloud, queries); };
  }

  ScratchDirectory scratch_;
  const TilePlan plan_ = PlanHills(scratch_, 3000, 200, {.neighbor_count = 20, .radius = 0.0, .factor = 1.0});
  std::atomic<size_t> calls_ = 0;
  std::stop_source stop_;
};

TEST_F(RunTilesTest, SeveralThreadsDoEachTileOnce) {
  ASSERT_GT(plan_.tiles.size(), 8u);
  std::vector<uint64_t> done;
  RunProgress last;
  const auto outcome = RunTiles(plan_, {.tile = {}, .jobs = 4}, Estimator(), {}, [&](const RunProgress& progress) {
    done.push_back(progress.tiles_done);
    last = progress;
  });
  ASSERT_TRUE(outcome.ok()) << outcome.status();
  EXPECT_EQ(outcome->tiles, plan_.tiles.size());
  EXPECT_EQ(outcome->points, 3000u);
  EXPECT_EQ(calls_, plan_.tiles.size());
  EXPECT_EQ(done.size(), plan_.tiles.size());
  EXPECT_TRUE(std::is_sorted(done.begin(), done.end()));
  EXPECT_EQ(last.tiles_done, last.tiles);
  EXPECT_EQ(last.points_done, 3000u);
  EXPECT_TRUE(StatusOf(plan_).is_complete());
}

TEST_F(RunTilesTest, RunsAtOnceShareTheTiles) {
  uint64_t tiles[2] = {};
  {
    std::vector<std::jthread> runs;
    for (uint64_t& own : tiles) {
      runs.emplace_back([this, &own] {
        const auto outcome = RunTiles(plan_, {.tile = {}, .jobs = 2}, Estimator(), {}, {});
        if (outcome.ok()) own = outcome->tiles;
      });
    }
  }
  EXPECT_EQ(tiles[0] + tiles[1], plan_.tiles.size());
  EXPECT_EQ(calls_, plan_.tiles.size());
  EXPECT_TRUE(StatusOf(plan_).is_complete());
}

TEST_F(RunTilesTest, AnErrorOfOneThreadEndsTheOthers) {
  std::atomic<int> left = 3;
  const TileEstimator failing = [&](const FloatArrays& cloud, const std::vector<uint32_t>& queries) {
    return left-- > 0 ? Answer(cloud, queries) : absl::UnavailableError("no server");
  };
  const auto outcome = RunTiles(plan_, {.tile = {}, .jobs = 4}, failing, {}, {});
  EXPECT_EQ(outcome.status(), absl::UnavailableError("no server"));
  EXPECT_EQ(StatusOf(plan_).tiles_done, 3u);
  EXPECT_TRUE(RunTiles(plan_, {}, Estimator(), {}, {}).ok());
  EXPECT_TRUE(StatusOf(plan_).is_complete());
}

TEST_F(RunTilesTest, AStopKeepsWhatIsDone) {
  const auto outcome =
      RunTiles(plan_, {.tile = {}, .jobs = 4}, Estimator(), stop_.get_token(), [&](const RunProgress& progress) {
        if (progress.tiles_done == 2) stop_.request_stop();
      });
  EXPECT_EQ(outcome.status().code(), absl::StatusCode::kCancelled);
  const TileStatus status = StatusOf(plan_);
  EXPECT_GE(status.tiles_done, 2u);
  EXPECT_LE(status.tiles_done, 5u);  // those that others had at hand
}

TEST_F(RunTilesTest, DoesOneTileAlone) {
  ASSERT_TRUE(RunTiles(plan_, {.tile = 3}, Estimator(), {}, {}).ok());
  const TileStatus status = StatusOf(plan_);
  EXPECT_EQ(status.tiles_done, 1u);
  EXPECT_THAT(std::vector<size_t>(status.tiles_left.begin(), status.tiles_left.begin() + 4), ElementsAre(0, 1, 2, 4));
  EXPECT_EQ(RunTiles(plan_, {.tile = plan_.tiles.size()}, Estimator(), {}, {}).status().code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace curv
