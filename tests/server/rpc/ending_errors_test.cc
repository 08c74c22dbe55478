#include "server/rpc/ending_errors.h"

#include <gtest/gtest.h>

#include "server/rpc/error_reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

TEST(CallerGoneTest, TellsADeadlineFromACancel) {
  EXPECT_TRUE(IsError(CallerGone(true), absl::StatusCode::kDeadlineExceeded, kReasonDeadlineExceeded, {"deadline"}));
  EXPECT_TRUE(IsError(CallerGone(false), absl::StatusCode::kCancelled, kReasonCancelled, {"cancelled"}));
}

TEST(CallerStallsTest, NamesTheLimit) {
  EXPECT_TRUE(IsError(CallerStalls(true, absl::Seconds(5)), absl::StatusCode::kDeadlineExceeded, kReasonStalled,
                      {"room to send", "5s", "stall_timeout"}));
  EXPECT_TRUE(IsError(CallerStalls(false, absl::Seconds(5)), absl::StatusCode::kDeadlineExceeded, kReasonStalled,
                      {"message", "5s", "stall_timeout"}));
}

TEST(CallerIsSlowTest, NamesThePace) {
  EXPECT_TRUE(IsError(CallerIsSlow(true, 1000, absl::Seconds(5)), absl::StatusCode::kDeadlineExceeded, kReasonStalled,
                      {"results taken", "5s", "1000", "others wait"}));
  EXPECT_TRUE(IsError(CallerIsSlow(false, 1000, absl::Seconds(5)), absl::StatusCode::kDeadlineExceeded, kReasonStalled,
                      {"points sent", "5s", "1000", "others wait"}));
}

TEST(DrainTimedOutTest, SaysSo) {
  EXPECT_TRUE(IsError(DrainTimedOut(absl::Seconds(5)), absl::StatusCode::kUnavailable, kReasonDrainTimeout,
                      {"draining", "5s", "drain_timeout", "another replica"}));
}

}  // namespace
}  // namespace curvd
