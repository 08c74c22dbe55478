#include "server/host/ticker.h"

#include <gtest/gtest.h>

#include <future>

namespace curvd {
namespace {

TEST(TickerTest, TicksAgainAndAgain) {
  std::promise<void> third;
  int count = 0;
  Ticker ticker(std::chrono::milliseconds(1), [&](Ticker::Clock::time_point) {
    if (++count == 3) third.set_value();
  });
  third.get_future().wait();
}

TEST(TickerTest, StopsWithoutWaitingForTheNextTick) {
  const auto start = Ticker::Clock::now();
  {
    Ticker ticker(std::chrono::hours(1), [](Ticker::Clock::time_point) {});
  }
  EXPECT_LT(Ticker::Clock::now() - start, std::chrono::minutes(1));
}

}  // namespace
}  // namespace curvd
