#include "server/call/job_errors.h"

#include <gtest/gtest.h>

#include "server/rpc/error_reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

TEST(ExplainJobErrorTest, TellsALargeNeighborhoodFromALackOfMemory) {
  EXPECT_TRUE(IsError(ExplainJobError(absl::ResourceExhaustedError("radius 9 gives 11 neighbors")),
                      absl::StatusCode::kResourceExhausted, kReasonNeighborhoodTooLarge, {"radius 9"}));
  EXPECT_TRUE(IsError(ExplainJobError(absl::ResourceExhaustedError("out of memory: no pages")),
                      absl::StatusCode::kResourceExhausted, kReasonOutOfMemory, {"no pages"}));
}

TEST(ExplainJobErrorTest, AnythingElseIsADefect) {
  EXPECT_TRUE(IsError(ExplainJobError(absl::CancelledError("nobody asked")), absl::StatusCode::kInternal,
                      kReasonInternal, {"nobody asked"}));
}

}  // namespace
}  // namespace curvd
