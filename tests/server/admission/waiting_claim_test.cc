#include "server/admission/waiting_claim.h"

#include <gtest/gtest.h>

namespace curvd {
namespace {

using Clock = WaitingClaim::Clock;
constexpr Clock::duration kMoment = std::chrono::milliseconds(1);

TEST(WaitingClaimTest, LetsOthersPassUntilTheyHadAsMuch) {
  WaitingClaim claim(100);
  const Clock::time_point now;
  EXPECT_TRUE(claim.LetsPass(now));
  claim.CountPassed(99);
  EXPECT_TRUE(claim.LetsPass(now));
  claim.CountPassed(1);
  EXPECT_FALSE(claim.ClaimsSince(now).has_value()) << "nobody has asked";
  EXPECT_FALSE(claim.LetsPass(now));
  EXPECT_EQ(claim.ClaimsSince(now), now);
}

TEST(WaitingClaimTest, RestsForAsLongAsItClaimedThenClaimsForTwiceAsLong) {
  WaitingClaim claim(0);
  Clock::time_point began;
  for (Clock::duration length = WaitingClaim::kFirstClaim; length <= WaitingClaim::kLongestClaim; length *= 2) {
    EXPECT_FALSE(claim.LetsPass(began));
    EXPECT_FALSE(claim.LetsPass(began + length - kMoment));
    EXPECT_TRUE(claim.ClaimsSince(began + length - kMoment).has_value());
    EXPECT_TRUE(claim.LetsPass(began + length));
    EXPECT_FALSE(claim.ClaimsSince(began + length).has_value());
    EXPECT_TRUE(claim.LetsPass(began + 2 * length - kMoment));
    began += 2 * length;
  }
  EXPECT_FALSE(claim.LetsPass(began));
  EXPECT_TRUE(claim.LetsPass(began + WaitingClaim::kLongestClaim)) << "it grows no longer";
}

}  // namespace
}  // namespace curvd
