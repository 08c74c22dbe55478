#include "server/server_options.h"

#include <gtest/gtest.h>

#include "server/reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

TEST(ServerOptionsTest, DefaultsAreValid) { EXPECT_TRUE(ServerOptions().Validate().ok()); }

TEST(ServerOptionsTest, NamesFlagValueAndLimitOfWhatIsOutOfRange) {
  ServerOptions options;
  options.threads = -1;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--threads", "-1", "[0, 4096]"}));
  options = {};
  options.max_points = 0;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--max-points", "0", "2147483647"}));
  options = {};
  options.max_chunk_bytes = 1;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--max-chunk-bytes", "1024"}));
  options = {};
  options.max_neighbor_count = 3;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--max-neighbor-count", "3"}));
  options = {};
  options.memory_limit_bytes = 1000;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--memory-limit", "1000", "33554432"}));
  options = {};
  options.max_streams = 0;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--max-streams", "0"}));
  options = {};
  options.max_waiting = 100'001;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--max-waiting", "100001"}));
  options = {};
  options.drain_timeout = -absl::Seconds(1);
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--drain-timeout", "-1s"}));
  options = {};
  options.stall_timeout = absl::ZeroDuration();
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--stall-timeout", "above 0s"}));
}

}  // namespace
}  // namespace curvd
