#include "server/observe/log_rate_limit.h"

#include <gtest/gtest.h>

namespace curvd {
namespace {

using std::chrono::milliseconds;

TEST(LogRateLimitTest, LetsSomeLinesASecondThroughAndCountsTheOthers) {
  LogRateLimit limit;
  const auto start = LogRateLimit::Clock::time_point() + std::chrono::hours(1);
  uint64_t left_out = 99;
  int written = 0;
  for (int i = 0; i < 1'000; ++i) {
    if (!limit.MayWrite(start + milliseconds(i / 2), left_out)) continue;
    EXPECT_EQ(left_out, 0u);
    ++written;
  }
  EXPECT_EQ(written, LogRateLimit::kLinesPerSecond);
  EXPECT_TRUE(limit.MayWrite(start + milliseconds(1'000), left_out));
  EXPECT_EQ(left_out, 980u);
  EXPECT_TRUE(limit.MayWrite(start + milliseconds(1'000), left_out));
  EXPECT_EQ(left_out, 0u);
}

}  // namespace
}  // namespace curvd
