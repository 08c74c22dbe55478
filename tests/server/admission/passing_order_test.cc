#include "server/admission/passing_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace curvd {
namespace {

using Clock = WaitingClaim::Clock;
constexpr uint64_t kWanted = 100;

class PassingOrderTest : public ::testing::Test {
 protected:
  // A head that lets others pass, or one that has let enough pass.
  void Add(uint64_t arrival, bool lets_pass, bool can_be_served = true) {
    if (!lets_pass) claims_[heads_.size()].CountPassed(kWanted);
    heads_.push_back({&claims_[heads_.size()], arrival, can_be_served});
  }
  PassingOrder Order() { return PassingOrder(heads_, now_); }

  const Clock::time_point now_{std::chrono::hours(1)};
  std::vector<WaitingClaim> claims_{500, WaitingClaim(kWanted)};
  std::vector<WaitingHead> heads_;
};

TEST_F(PassingOrderTest, TheFirstOfAllMayGo) {
  Add(1, false);
  Add(2, false);
  EXPECT_TRUE(Order().MayGo(0));
}

TEST_F(PassingOrderTest, WhoHasAnEarlierTurnMustLetOthersPass) {
  Add(2, true);
  Add(1, true);
  EXPECT_TRUE(Order().MayGo(1));
  claims_[0].CountPassed(kWanted);
  EXPECT_FALSE(Order().MayGo(1));
}

TEST_F(PassingOrderTest, WhoCameEarlierMustLetOthersPass) {
  Add(2, true);
  Add(1, false);
  EXPECT_FALSE(Order().MayGo(0));
  EXPECT_TRUE(claims_[1].ClaimsSince(now_).has_value()) << "it claims from now on";
  EXPECT_TRUE(Order().MayGo(1));
}

TEST_F(PassingOrderTest, WhoCouldNotBeServedHoldsUpNobody) {
  Add(1, false, /*can_be_served=*/false);
  Add(2, true);
  EXPECT_TRUE(Order().MayGo(1));
}

TEST_F(PassingOrderTest, OfTwoClaimsTheEarlierGoes) {
  Add(2, false);
  Add(1, false);
  claims_[0].LetsPass(now_ - std::chrono::seconds(1));
  claims_[1].LetsPass(now_);
  PassingOrder order = Order();
  EXPECT_TRUE(order.MayGo(0));
  EXPECT_FALSE(order.MayGo(1));
}

// The rule as it is written, with everybody asked about everybody.
bool MayGoAmong(const std::vector<WaitingHead>& heads, size_t next, Clock::time_point now) {
  for (size_t other = 0; other < heads.size(); ++other) {
    if (other == next || !heads[other].can_be_served) continue;
    if (other > next && heads[other].arrival > heads[next].arrival) continue;
    const auto own = heads[next].claim->ClaimsSince(now), others = heads[other].claim->ClaimsSince(now);
    if (own.has_value() &&
        (!others.has_value() || *own < *others || (*own == *others && heads[next].arrival < heads[other].arrival))) {
      continue;
    }
    WaitingClaim copy = *heads[other].claim;
    if (!copy.LetsPass(now)) return false;
  }
  return true;
}

TEST_F(PassingOrderTest, FollowsTheRuleWhateverTheOrder) {
  std::mt19937 random(7);
  const auto one_of = [&random](uint32_t count) { return random() % count == 0; };
  int may = 0, may_not = 0;
  for (int trial = 0; trial < 2'000; ++trial) {
    heads_.clear();
    claims_.clear();
    for (int i = 0; i < 12; ++i) claims_.emplace_back(kWanted);
    std::vector<uint64_t> arrivals(12);
    std::iota(arrivals.begin(), arrivals.end(), 1);
    std::shuffle(arrivals.begin(), arrivals.end(), random);
    for (const uint64_t arrival : arrivals) Add(arrival, !one_of(8), !one_of(5));
    for (WaitingClaim& claim : claims_) {
      if (one_of(4)) claim.LetsPass(now_ - std::chrono::seconds(random() % 8));
    }
    // A caller whose turn comes late is not asked about before the others: each is alone in its order.
    for (size_t next = 0; next < heads_.size(); ++next) {
      std::vector<WaitingClaim> claims = claims_;
      std::vector<WaitingHead> heads = heads_;
      for (size_t i = 0; i < heads.size(); ++i) heads[i].claim = &claims[i];
      const bool expected = MayGoAmong(heads_, next, now_);
      ASSERT_EQ(PassingOrder(heads, now_).MayGo(next), expected) << "trial " << trial << ", head " << next;
      (expected ? may : may_not)++;
    }
    // One order for all says the same, as long as nobody begins to claim meanwhile.
    PassingOrder order = Order();
    for (size_t next = 0; next < heads_.size(); ++next) {
      const bool expected = MayGoAmong(heads_, next, now_);
      ASSERT_EQ(order.MayGo(next), expected) << "trial " << trial << ", head " << next;
    }
  }
  EXPECT_GT(may, 1'000);
  EXPECT_GT(may_not, 1'000);
}

}  // namespace
}  // namespace curvd
