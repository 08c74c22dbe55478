#include "core/job/phases/group_phase.h"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

using std::chrono::milliseconds;

constexpr size_t kPoints = 40 * SpatialIndex::kGroupPoints;

// A scratch whose steps the test counts.
struct CountedScratch final : WorkerScratch {
  size_t bytes() const override { return sizeof(*this); }
  uint64_t work() const override { return steps; }
  uint64_t steps = 0;
};

class CountedRun final : public StrategyRun {
 public:
  std::unique_ptr<WorkerScratch> MakeScratch() const override { return std::make_unique<CountedScratch>(); }
  std::vector<GroupPhase> Phases() override { return {}; }
};

// A part of a group that was run: the group, and its first point.
using Part = std::pair<size_t, size_t>;

// Runs the blocks of a phase in one thread, those that it adds included, by a clock that the test sets.
class GroupPhaseTest : public ::testing::Test {
 protected:
  void SetUp() override { time_ = {}; }

  // Runs `groups`, four a block, and notes what each block has run.
  absl::Status RunAll(absl::FunctionRef<absl::Status(size_t group, CountedScratch& scratch)> groups) {
    const std::unique_ptr<Phase> phase = MakeGroupPhase({"groups", nullptr,
                                                         [&](size_t group, WorkerScratch& scratch) {
                                                           blocks_.back().emplace_back(group, scratch.first_point);
                                                           return groups(group, static_cast<CountedScratch&>(scratch));
                                                         }},
                                                        index_, 4, scratch_, &points_done_, [] { return time_; });
    std::deque<size_t> open;
    for (size_t block = 0, count = *phase->Begin(); block < count; ++block) open.push_back(block);
    for (; !open.empty(); open.pop_front()) {
      blocks_.emplace_back();
      const auto add_block = [&open](size_t added) { open.insert(open.begin() + 1, added); };
      if (absl::Status status = phase->RunBlock({open.front(), 0, stopped_, add_block}); !status.ok()) return status;
      done_after_.push_back(points_done_);
    }
    return phase->End();
  }

  static void Pass(milliseconds time) { time_ += time; }

  const SpatialIndex index_ = BuildIndex(Sphere(kPoints, 1.0).ToCloud());
  CountedRun run_;
  ScratchSet scratch_{run_, 1};
  std::atomic<size_t> points_done_ = 0;
  std::atomic<bool> stopped_ = false;
  std::vector<std::vector<Part>> blocks_;  // in the order of their turns
  std::vector<size_t> done_after_;         // points, after each block

 private:
  static inline std::chrono::steady_clock::time_point time_;
};

TEST_F(GroupPhaseTest, AQuickBlockRunsAllItsGroups) {
  const auto quick = [](size_t, CountedScratch&) {
    Pass(milliseconds(1));
    return absl::OkStatus();
  };
  ASSERT_TRUE(RunAll(quick).ok());
  ASSERT_EQ(blocks_.size(), 10u);
  EXPECT_EQ(blocks_[0], (std::vector<Part>{{0, 0}, {1, 0}, {2, 0}, {3, 0}}));
  EXPECT_EQ(blocks_[9], (std::vector<Part>{{36, 0}, {37, 0}, {38, 0}, {39, 0}}));
  EXPECT_EQ(points_done_, kPoints);
}

TEST_F(GroupPhaseTest, ABlockThatTakesLongLeavesItsOtherGroupsToAnotherTurn) {
  // Group 1 takes long, and group 7, which is the last of its block.
  const auto run = [](size_t group, CountedScratch&) {
    Pass(group == 1 || group == 7 ? kLongBlock : milliseconds(1));
    return absl::OkStatus();
  };
  ASSERT_TRUE(RunAll(run).ok());
  ASSERT_EQ(blocks_.size(), 11u);
  EXPECT_EQ(blocks_[0], (std::vector<Part>{{0, 0}, {1, 0}}));
  EXPECT_EQ(blocks_[1], (std::vector<Part>{{2, 0}, {3, 0}}));
  EXPECT_EQ(blocks_[2], (std::vector<Part>{{4, 0}, {5, 0}, {6, 0}, {7, 0}}));
  EXPECT_EQ(done_after_[0], 2 * SpatialIndex::kGroupPoints);
  EXPECT_EQ(points_done_, kPoints);
}

TEST_F(GroupPhaseTest, ABlockIsNotLongWhereItTakesNoLongerThanTheLimit) {
  const auto run = [](size_t group, CountedScratch&) {
    Pass(group == 0 ? kLongBlock : milliseconds(0));
    return absl::OkStatus();
  };
  ASSERT_TRUE(RunAll(run).ok());
  EXPECT_EQ(blocks_.size(), 10u);
}

TEST_F(GroupPhaseTest, ABlockOfManyStepsLeavesItsOtherGroupsToAnotherTurn) {
  const auto run = [](size_t group, CountedScratch& scratch) {
    scratch.steps += group == 5 ? WorkerScratch::kMostRunWork : 1;
    return absl::OkStatus();
  };
  ASSERT_TRUE(RunAll(run).ok());
  ASSERT_EQ(blocks_.size(), 11u);
  EXPECT_EQ(blocks_[1], (std::vector<Part>{{4, 0}, {5, 0}}));
  EXPECT_EQ(blocks_[2], (std::vector<Part>{{6, 0}, {7, 0}}));
  EXPECT_EQ(points_done_, kPoints);
}

TEST_F(GroupPhaseTest, TheRestOfAGroupComesInAnotherTurnAndCountsWithItsEnd) {
  const auto run = [](size_t group, CountedScratch& scratch) {
    if ((group == 2 || group == 39) && scratch.first_point < 40) scratch.rest = scratch.first_point + 20;
    return absl::OkStatus();
  };
  ASSERT_TRUE(RunAll(run).ok());
  ASSERT_EQ(blocks_.size(), 14u);
  EXPECT_EQ(blocks_[0], (std::vector<Part>{{0, 0}, {1, 0}, {2, 0}}));
  EXPECT_EQ(blocks_[1], (std::vector<Part>{{2, 20}}));
  EXPECT_EQ(blocks_[2], (std::vector<Part>{{2, 40}, {3, 0}}));
  EXPECT_EQ(blocks_[13], (std::vector<Part>{{39, 40}}));
  EXPECT_EQ(done_after_[0], 2 * SpatialIndex::kGroupPoints);
  EXPECT_EQ(done_after_[1], 2 * SpatialIndex::kGroupPoints);
  EXPECT_EQ(done_after_[2], 4 * SpatialIndex::kGroupPoints);
  EXPECT_EQ(points_done_, kPoints);
}

TEST_F(GroupPhaseTest, AStoppedBlockRunsNoOtherGroup) {
  const auto run = [this](size_t group, CountedScratch&) {
    if (group == 1) stopped_ = true;
    return absl::OkStatus();
  };
  ASSERT_TRUE(RunAll(run).ok());
  EXPECT_EQ(blocks_[0], (std::vector<Part>{{0, 0}, {1, 0}}));
  for (size_t block = 1; block < blocks_.size(); ++block) EXPECT_TRUE(blocks_[block].empty());
  EXPECT_EQ(points_done_, 0u);
}

}  // namespace
}  // namespace curvd::testing
