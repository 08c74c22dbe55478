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
  EXPECT_EQ(JsonLine().Add("a", "q\" b\\ n\n t\x01").str(), R"({"a":"q\" b\\ n\n t\u0001"})");
}

TEST(JsonLineTest, NeverLeavesAscii) {
  EXPECT_EQ(JsonLine().Add("a", "Gesch\u00fctz \u6811 \U0001F409").str(),
            "{\"a\":\"Gesch\\u00fctz \\u6811 \\ud83d\\udc09\"}");
}

TEST(JsonLineTest, ReplacesBytesThatAreNoText) {
  EXPECT_EQ(JsonLine().Add("a", "\x9b \xff \xc2").str(), "{\"a\":\"\\ufffd \\ufffd \\ufffd\"}");
}

// As bytes, and as UTF-8, in which 0x9b is a command to a terminal too.
TEST(JsonLineTest, EscapesWhatCommandsTerminals) {
  EXPECT_EQ(JsonLine().Add("a", "\x1b[2J \x7f \u0080 \u009b \u00a0").str(),
            "{\"a\":\"\\u001b[2J \\u007f \\u0080 \\u009b \\u00a0\"}");
}

TEST(JsonLineTest, HasNoNumberForWhatIsNotFinite) {
  EXPECT_EQ(JsonLine().Add("a", std::nan("")).Add("b", HUGE_VAL).str(), R"({"a":null,"b":null})");
}

TEST(JsonLineTest, MayBeEmpty) { EXPECT_EQ(JsonLine().str(), "{}"); }

}  // namespace
}  // namespace curvd
