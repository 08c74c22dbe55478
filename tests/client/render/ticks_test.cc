#include "client/render/ticks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace curv {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> Labels(double low, double high) {
  std::vector<std::string> labels;
  for (const Tick& tick : RoundTicks(low, high).ticks) labels.push_back(tick.label);
  return labels;
}

TEST(TicksTest, AreRound) {
  EXPECT_THAT(Labels(-0.107, 0.345), ElementsAre("\u22120.1", "0.0", "0.1", "0.2", "0.3"));
  EXPECT_THAT(Labels(-1, 1), ElementsAre("\u22121.0", "\u22120.5", "0.0", "0.5", "1.0"));
  EXPECT_THAT(Labels(0, 100), ElementsAre("0", "20", "40", "60", "80", "100"));
  EXPECT_THAT(Labels(0, 90'000), ElementsAre("0", "20000", "40000", "60000", "80000"));
}

TEST(TicksTest, LongNumbersShareAPowerOfTen) {
  EXPECT_THAT(Labels(-3e-6, 3e-6), ElementsAre("\u22123", "\u22122", "\u22121", "0", "1", "2", "3"));
  EXPECT_EQ(RoundTicks(-3e-6, 3e-6).exponent, -6);
  EXPECT_THAT(Labels(-2e6, 2e6), ElementsAre("\u22122", "\u22121", "0", "1", "2"));
  EXPECT_EQ(RoundTicks(-2e6, 2e6).exponent, 6);
  EXPECT_EQ(RoundTicks(0, 5e-4).exponent, 0);
}

TEST(TicksTest, StayFewAndDifferentForAnyRange) {
  for (double size = 1e-12; size < 1e12; size *= 1.7) {
    for (const double low : {-size, -0.1 * size, 0.0, 5.0 * size}) {
      const std::vector<std::string> labels = Labels(low, low + 1.3 * size);
      EXPECT_GE(labels.size(), 3u);
      EXPECT_LE(labels.size(), 9u);
      EXPECT_EQ(std::set(labels.begin(), labels.end()).size(), labels.size()) << low << " " << size;
    }
  }
}

TEST(SuperscriptTest, WritesEveryDigit) {
  EXPECT_EQ(Superscript(-10), "\u207b\u00b9\u2070");
  EXPECT_EQ(Superscript(23456789), "\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079");
}

}  // namespace
}  // namespace curv
