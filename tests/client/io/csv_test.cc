#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "client/io/formats.h"
#include "client/io/table_file.h"
#include "tests/client/io/samples.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsNan;

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

// They are those of other programs.
TEST(CsvTest, ReadsStatusesThatNoWordStandsForAsNumbers) {
  const TempDir dir;
  PointTable table = *ReadCsv("x,status,status_k8\n1,ok,2.5\n2,-300,\n3,too_few_neighbors,255\n");
  EXPECT_THAT(Values(table, "status"), ElementsAre(1, -300, 2));
  EXPECT_THAT(Values(table, "status_k8"), ElementsAre(2.5, IsNan(), 255));
  table.Set({"status_k16", std::vector<uint8_t>{0, 8, 9}});
  ASSERT_TRUE(SaveTable(table, dir.File("t.csv")).ok());
  EXPECT_THAT(dir.Read("t.csv"), HasSubstr("\n1,1,2.5,unspecified\n2,-300,nan,outlier\n3,2,255,9\n"));
  const absl::StatusOr<PointTable> read = LoadTable(dir.File("t.csv"));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_THAT(Values(*read, "status_k16"), ElementsAre(0, 8, 9));
  EXPECT_EQ(read->Find("status_k16")->kind(), ScalarKind::kUint8);
}

TEST(CsvTest, TakesTheIndexOfOtherPrograms) {
  for (const char* file : {",x,y\n7,1,2\n", "\"\",\"x\",\"y\"\n\"7\",1,2\n"}) {
    const absl::StatusOr<PointTable> table = ReadCsv(file);
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_THAT(Values(*table, "index"), ElementsAre(7)) << file;
    EXPECT_THAT(Values(*table, "y"), ElementsAre(2)) << file;
  }
  EXPECT_THAT(Values(*ReadCsv(",index\n7,8\n"), "index_2"), ElementsAre(7));
}

TEST(CsvTest, EmptyCellsAreNanButInPositionsAndNormals) {
  const absl::StatusOr<PointTable> table = ReadCsv("x,i,j\n1,,3\n2,5,\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "i"), ElementsAre(IsNan(), 5));
  EXPECT_THAT(Values(*table, "j"), ElementsAre(3, IsNan()));
  EXPECT_THAT(Message("x,Normal_Y\n1,\n"), HasSubstr("line 2: value 2 (ny) is \"\": expected a number"));
}

TEST(CsvTest, TakesASeparatorAtTheEndOfAllLines) {
  const absl::StatusOr<PointTable> table = ReadCsv("x;y;\n1;2;\n3;4\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "y"), ElementsAre(2, 4));
  EXPECT_EQ(table->columns().size(), 2u);
  EXPECT_THAT(Message("x,y,\n1,2,3\n"), HasSubstr("line 2: value 3 is \"3\": its column has no name"));
  EXPECT_THAT(Message("x,y,\n1,2,,\n"), HasSubstr("line 2: expected 2 values, found 4"));
}

TEST(CsvTest, TakesNamesInAComment) {
  for (const char* file : {"# x,y,k1\n1,2,3\n", "//X,Y,k1\n1,2,3\n", "\xef\xbb\xbf#x;y;k1\n1;2;3\n"}) {
    const absl::StatusOr<PointTable> table = ReadCsv(file);
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_THAT(Values(*table, "x"), ElementsAre(1)) << file;
    EXPECT_THAT(Values(*table, "k1"), ElementsAre(3)) << file;
  }
}

TEST(CsvTest, SeparatorsInQuotesSeparateNothing) {
  absl::StatusOr<PointTable> table = ReadCsv("\"size, \"\"m\"\"\",x\n\"1\",2\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "size, \"m\""), ElementsAre(1));
  table = ReadCsv("x;\"size, m\"\n1;2\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "size, m"), ElementsAre(2));
}

TEST(CsvTest, LeavesOutWords) {
  const absl::StatusOr<PointTable> table =
      ReadCsv("x,class,day,y\n1,,2026-11-29,2\n3,\"tree, old\",2026-11-30,4\n5,7,,6\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "y"), ElementsAre(2, 4, 6));
  EXPECT_EQ(table->columns().size(), 2u);
  EXPECT_THAT(table->notes,
              ElementsAre("left out column class: it holds words", "left out column day: it holds words"));
  EXPECT_THAT(Message("x,i\n1,2\n3,tree\n"), HasSubstr("line 3: value 2 (i) is \"tree\": expected a number"));
  EXPECT_THAT(Message("x,i\n1,1e400\n"), HasSubstr("value 2 (i) is \"1e400\""));
  EXPECT_THAT(Message("x,i\n1,\"0,5\"\n"), HasSubstr("expected a number with a point, not a comma"));
  EXPECT_THAT(Message("x,i\nleft,2\n"), HasSubstr("value 1 (x) is \"left\""));
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
  EXPECT_THAT(Message("x,status\n1,fine\n"), HasSubstr("expected a status word, or a number"));
}

TEST(CsvTest, TellsTextInUtf16) {
  EXPECT_THAT(Message(std::string("x\0,\0y\0,\0z\0\n\0", 12)),
              HasSubstr("line 1 has bytes of 0, as text in UTF-16 has"));
}

TEST(CsvTest, TellsNumbersInPlaceOfNames) {
  EXPECT_THAT(Message("1,2.5,-3\n4,5,6\n"), HasSubstr("line 1: expected the columns' names, found numbers"));
}

TEST(CsvTest, SurvivesTruncationAndDamage) {
  AcceptedPrefixes(ReadCsv, "x,y,status\n1.5,-2e3,ok\nnan,inf,invalid_input\n");
}

TEST(CsvTest, ShowsNoNameThatATerminalObeys) {
  EXPECT_THAT(Message("x,\x1b[2J\n1,2\n1,a\n"), HasSubstr("value 2 (?[2J) is"));
}

TEST(CsvTest, RefusesMoreColumnsThanATableHolds) {
  std::string names = "c0";
  for (size_t i = 1; i <= kMaxColumns; ++i) names += ",c" + std::to_string(i);
  EXPECT_THAT(Message(names), HasSubstr("more than 4096 columns"));
  EXPECT_TRUE(ReadCsv(names.substr(0, names.rfind(','))).ok());
}

}  // namespace
}  // namespace curv
