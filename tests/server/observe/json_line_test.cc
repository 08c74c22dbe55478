#include "server/observe/json_line.h"

#include <gtest/gtest.h>

#include <cmath>

namespace curvd {
namespace {

TEST(JsonLineTest, WritesEachTypeInOrder) {
  EXPECT_EQ(JsonLine().Add("a", "x").Add("b", 7).Add("c", 0.5).Add("d", true).Add("e", uint64_t{1} << 40).str(),
            R"({"a":"x","b":7,"c":0.5,"d":true,"e":1099511627776})");
}

TEST(JsonLineTest, EscapesWhatJsonCannotHold) {
  EXPECT_EQ(JsonLine().Add("a", "q\" b\\ n\n t\x01").str(), R"({"a":"q\" b\\ n\u000a t\u0001"})");
  EXPECT_EQ(JsonLine().Add("a", "\x7f \x9b \xff").str(), R"({"a":"\u007f \u009b \u00ff"})");
}

TEST(JsonLineTest, HasNoNumberForWhatIsNotFinite) {
  EXPECT_EQ(JsonLine().Add("a", std::nan("")).Add("b", HUGE_VAL).str(), R"({"a":null,"b":null})");
}

TEST(JsonLineTest, MayBeEmpty) { EXPECT_EQ(JsonLine().str(), "{}"); }

}  // namespace
}  // namespace curvd
