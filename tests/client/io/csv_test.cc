#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "client/io/formats.h"
#include "tests/client/io/samples.h"

namespace curv {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string Message(const std::string& file) { return std::string(ReadCsv(file).status().message()); }

TEST(CsvTest, ReadsNamesNumbersAndStatuses) {
  const absl::StatusOr<PointTable> table = ReadCsv("x, k1 ,status\r\n1.5,nan,degenerate_area\r\n\r\n-2,3,ok\r\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "x"), ElementsAre(1.5, -2));
  EXPECT_TRUE(std::isnan(Values(*table, "k1")[0]));
  EXPECT_THAT(Values(*table, "status"), ElementsAre(3, 1));
}

TEST(CsvTest, ReadsStatusesOfScalesAsWordsOrNumbers) {
  const absl::StatusOr<PointTable> table = ReadCsv("x,status_k16,status_of\n1,ok,7\n2,6,8\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "status_k16"), ElementsAre(1, 6));
  EXPECT_THAT(Values(*table, "status_of"), ElementsAre(7, 8));
}

TEST(CsvTest, TakesByteOrderMarksQuotesAndCapitals) {
  const absl::StatusOr<PointTable> table =
      ReadCsv("\xef\xbb\xbf\"X\", Y,\"Z\",\"NX\",Intensity\n1,2,\"3\",\" 4 \",5\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "x"), ElementsAre(1));
  EXPECT_THAT(Values(*table, "z"), ElementsAre(3));
  EXPECT_THAT(Values(*table, "nx"), ElementsAre(4));
  EXPECT_THAT(Values(*table, "Intensity"), ElementsAre(5));
  EXPECT_THAT(Message("x,X\n"), HasSubstr("two columns have the name \"x\""));
  EXPECT_THAT(Message("x,\"\"\n"), HasSubstr("column 2 has no name"));
  EXPECT_THAT(Message("x\n\"1\n"), HasSubstr("line 2: value 1 (x) is \"\"1\""));
}

TEST(CsvTest, TakesSemicolonsAndTabs) {
  for (const char* file : {"x;\"y\";status\n1;2;ok\n", "x\ty\tstatus\r\n1\t 2\tok\r\n"}) {
    const absl::StatusOr<PointTable> table = ReadCsv(file);
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_THAT(Values(*table, "y"), ElementsAre(2)) << file;
  }
  EXPECT_THAT(Message("x;y\n0,5;1\n"), HasSubstr("line 2: value 1 (x) is \"0,5\": expected a number with a point"));
  EXPECT_THAT(Message("x;y\n1,2\n"), HasSubstr("value 1 (x) is \"1,2\""));
  EXPECT_THAT(Message("x,y;z\n1,2;3\n"), HasSubstr("value 2 (y;z) is \"2;3\""));
}

TEST(CsvTest, NamesLineAndValue) {
  EXPECT_THAT(Message(""), HasSubstr("the file is empty"));
  EXPECT_THAT(Message("x,,y\n"), HasSubstr("column 2 has no name"));
  EXPECT_THAT(Message("x,x\n"), HasSubstr("two columns have the name \"x\""));
  EXPECT_THAT(Message("x,y\n1,2\n1\n"), HasSubstr("line 3: expected 2 values, found 1"));
  EXPECT_THAT(Message("x,y\n1,2,3\n"), HasSubstr("line 2: expected 2 values, found 3"));
  EXPECT_THAT(Message("x,y\n1,\n"), HasSubstr("line 2: value 2 (y) is \"\""));
  EXPECT_THAT(Message("x,status\n1,fine\n"), HasSubstr("expected a status word, or its number"));
  EXPECT_THAT(Message("x,status_k16\n1,256\n"), HasSubstr("expected a status word, or its number"));
}

TEST(CsvTest, SurvivesTruncationAndDamage) {
  AcceptedPrefixes(ReadCsv, "x,y,status\n1.5,-2e3,ok\nnan,inf,invalid_input\n");
}

TEST(CsvTest, ShowsNoNameThatATerminalObeys) {
  EXPECT_THAT(Message("x,\x1b[2J\n1,a\n"), HasSubstr("value 2 (?[2J) is"));
}

TEST(CsvTest, RefusesMoreColumnsThanATableHolds) {
  std::string names = "c0";
  for (size_t i = 1; i <= kMaxColumns; ++i) names += ",c" + std::to_string(i);
  EXPECT_THAT(Message(names), HasSubstr("more than 4096 columns"));
  EXPECT_TRUE(ReadCsv(names.substr(0, names.rfind(','))).ok());
}

}  // namespace
}  // namespace curv
