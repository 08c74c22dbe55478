#include "client/io/text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

namespace curv {
namespace {

template <typename T>
bool Parses(std::string_view field, T expected) {
  T value;
  return ParseNumber(field, value) && value == expected;
}

template <typename T>
bool Refuses(std::string_view field) {
  T value;
  return !ParseNumber(field, value);
}

TEST(TextTest, LinesEndInEachWay) {
  for (const std::string_view text : {"a\n\nb c\nd", "a\r\n\r\nb c\r\nd\r\n", "a\r\rb c\rd\r", "a\r\r\nb c\rd\n"}) {
    LineReader lines(text);
    std::vector<std::string> read;
    for (std::string_view line; lines.Next(line);) read.emplace_back(line);
    EXPECT_EQ(read, (std::vector<std::string>{"a", "", "b c", "d"})) << text;
    EXPECT_EQ(lines.number(), 4u);
    EXPECT_EQ(lines.rest(), "");
  }
}

TEST(TextTest, ParsesNumbers) {
  EXPECT_TRUE(Parses("1.5", 1.5));
  EXPECT_TRUE(Parses("+1e2", 100.0));
  EXPECT_TRUE(Parses("-.5", -0.5f));
  EXPECT_TRUE(Parses("inf", INFINITY));
  EXPECT_TRUE(Parses("-7", int8_t{-7}));
  EXPECT_TRUE(Parses("1e-400", 0.0));
  EXPECT_TRUE(Parses("-1e-60", -0.0f));
  EXPECT_TRUE(Parses("5e-324", 5e-324));
  EXPECT_TRUE(Parses("3e-324", 5e-324));  // to the nearest
  EXPECT_TRUE(Parses("1e-45", 1e-45f));
}

TEST(TextTest, TakesWhatIsTooSmallForZeroAndRefusesWhatIsTooLarge) {
  const std::string zeros(500, '0');
  for (const std::string& tiny :
       std::vector<std::string>{"0." + zeros + "1", "1e-99999999999999999999", "0." + zeros + "1e100", zeros + "1e-400",
                                "1" + zeros + "e-1000", "12.5E-400"}) {
    EXPECT_TRUE(Parses(tiny, 0.0)) << tiny;
    EXPECT_TRUE(Parses("-" + tiny, -0.0f)) << tiny;
  }
  double zero = 1.0;
  EXPECT_TRUE(ParseNumber("-1e-400", zero) && std::signbit(zero));
  for (const std::string& large : std::vector<std::string>{"1" + zeros, "1e+99999999999999999999",
                                                           "1" + zeros + "e-100", "0." + zeros + "1e1000"}) {
    EXPECT_TRUE(Refuses<double>(large)) << large;
    EXPECT_TRUE(Refuses<float>("-" + large)) << large;
  }
  EXPECT_TRUE(Parses("1" + zeros + "e-500", 1.0));
  EXPECT_TRUE(Parses("0." + zeros + "1e501", 1.0));
}

TEST(TextTest, RefusesWhatIsNoNumber) {
  for (const char* field : {"", "+", "-", "++1", "1x", "x", "1,5", "0x10", "1e", "1e999", "-1e999", "e5", " 1"}) {
    EXPECT_TRUE(Refuses<double>(field)) << field;
  }
  EXPECT_TRUE(Refuses<float>("1e39"));
  EXPECT_TRUE(Refuses<uint8_t>("256"));
  EXPECT_TRUE(Refuses<uint8_t>("-1"));
  EXPECT_TRUE(Refuses<int32_t>("1.0"));
}

TEST(TextTest, SplitsLines) {
  LineReader lines("a\r\n\nb", 5);
  std::string_view line;
  ASSERT_TRUE(lines.Next(line));
  EXPECT_EQ(line, "a");
  EXPECT_EQ(lines.number(), 5u);
  ASSERT_TRUE(lines.Next(line));
  EXPECT_EQ(line, "");
  ASSERT_TRUE(lines.Next(line));
  EXPECT_EQ(line, "b");
  EXPECT_FALSE(lines.Next(line));
}

TEST(TextTest, QuotesShortAndPrintable) {
  EXPECT_EQ(Quoted("a\n\xff"), "\"a??\"");
  EXPECT_EQ(Quoted(std::string(100, 'x')), "\"" + std::string(40, 'x') + "...\"");
}

TEST(TextTest, ShowsNothingThatATerminalObeys) {
  EXPECT_EQ(Printable("x\x1b[2J\x7f"), "x?[2J?");
  EXPECT_EQ(Printable("\xc2\x9b"
                      "2J"),
            "?2J");
}

TEST(TextTest, ShowsTheLettersOfAllScripts) {
  const std::string word =
      "gr\xc3\xb6\xc3\x9f"
      "e \xe5\x88\x97 \xf0\x9f\x93\x8f\xc2\xa0";
  EXPECT_EQ(Printable(word), word);
  EXPECT_EQ(Printable("\xc3 \xed\xa0\x80 \xc0\xaf"), "? ??? ??");
  EXPECT_EQ(Printable(std::string(39, 'x') + "\xc3\xb6"), std::string(39, 'x') + "...");
}

}  // namespace
}  // namespace curv
