#include "server/call/progress_message.h"

#include <gtest/gtest.h>

namespace curvd {
namespace {

namespace v1 = curvature::v1;

TEST(FillProgressTest, ReceivesUntilThereIsAJob) {
  v1::Progress progress;
  FillProgress(7, std::nullopt, &progress);
  EXPECT_EQ(progress.phase(), v1::Progress::PHASE_RECEIVING);
  EXPECT_EQ(progress.points_received(), 7u);
  EXPECT_EQ(progress.points_estimated(), 0u);
}

TEST(FillProgressTest, TellsThePhaseOfTheJob) {
  const std::pair<JobPhase, v1::Progress::Phase> phases[] = {
      {JobPhase::kQueued, v1::Progress::PHASE_QUEUED},
      {JobPhase::kIndexing, v1::Progress::PHASE_INDEXING},
      {JobPhase::kMakingNormals, v1::Progress::PHASE_ESTIMATING_NORMALS},
      {JobPhase::kOrienting, v1::Progress::PHASE_ORIENTING},
      {JobPhase::kEstimating, v1::Progress::PHASE_ESTIMATING},
      {JobPhase::kDone, v1::Progress::PHASE_SENDING}};
  for (const auto& [phase, shown] : phases) {
    JobProgress job;
    job.phase = phase;
    job.points_estimated = 5;
    v1::Progress progress;
    FillProgress(7, job, &progress);
    EXPECT_EQ(progress.phase(), shown);
    EXPECT_EQ(progress.points_estimated(), 5u);
  }
}

}  // namespace
}  // namespace curvd
