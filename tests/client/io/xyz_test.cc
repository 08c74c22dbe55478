#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/io/formats.h"
#include "tests/client/io/samples.h"

namespace curv {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string Message(const std::string& file) { return std::string(ReadXyz(file).status().message()); }

TEST(XyzTest, ReadsPositionsAndNormals) {
  const absl::StatusOr<PointTable> table =
      ReadXyz("# x y Mean_Curvature nx ny\n// more\n\n1 2 3 0 0 1\r\n  4\t5 6e1 1 0 0");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "x"), ElementsAre(1, 4));
  EXPECT_THAT(Values(*table, "z"), ElementsAre(3, 60));
  EXPECT_THAT(Values(*table, "nz"), ElementsAre(1, 0));
}

TEST(XyzTest, KeepsFurtherColumns) {
  const absl::StatusOr<PointTable> table = ReadXyz("1 2 3 0 0 1 0.5 7\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "column7"), ElementsAre(0.5));
  EXPECT_THAT(Values(*table, "column8"), ElementsAre(7));
}

TEST(XyzTest, TakesCommasAndSemicolons) {
  const absl::StatusOr<PointTable> table = ReadXyz("1, 2,3; 0 0 1\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "nz"), ElementsAre(1));
}

// The cells behind it would be taken for those of other columns.
TEST(XyzTest, RefusesEmptyCells) {
  EXPECT_THAT(Message("1,2,3\n0,0,,7\n"), HasSubstr("line 2: value 3 (z) is \"\": expected a number"));
  EXPECT_THAT(Message("0;;2;3\n"), HasSubstr("line 1: value 2 (y) is \"\": expected a number"));
  EXPECT_THAT(Message("# x y z k1\n1,2,3,\t,4\n"), HasSubstr("line 2: value 4 (column4) is \"\""));
  EXPECT_THAT(Message("# x y z k1\n1,2,3,4\n1,2,3,,\n"), HasSubstr("line 3: value 4 (k1) is \"\""));
  EXPECT_THAT(Message(",1,2,3\n"), HasSubstr("value 1 (x) is \"\""));
  EXPECT_THAT(Message("1,2,3\n1,2,3,,\n"), HasSubstr("line 2: value 4 is \"\""));
  for (const char* file : {"1,2,3,\n4,5,6,\n", "1, 2; 3 ;\n4 5 6\n", "1,2,3\n,,\n4,5,6\n"}) {
    const absl::StatusOr<PointTable> table = ReadXyz(file);
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_THAT(Values(*table, "z"), ElementsAre(3, 6)) << file;
  }
}

TEST(XyzTest, TakesCarriageReturnsForLineEnds) {
  const auto table = ReadXyz("1 2 3\r4 5 6\r7 8 9\r");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->size(), 3u);
}

TEST(XyzTest, TakesAByteOrderMark) {
  EXPECT_THAT(Values(*ReadXyz("\xef\xbb\xbf"
                              "1 2 3\n"),
                     "x"),
              ElementsAre(1));
}

TEST(XyzTest, TakesACount) {
  EXPECT_TRUE(ReadXyz("2\n1 2 3\n4 5 6\n").ok());
  EXPECT_THAT(Message("3\n1 2 3\n4 5 6\n"), HasSubstr("declares 3 points, the file holds 2"));
}

TEST(XyzTest, ThreeColumnsHaveNoNormals) {
  const absl::StatusOr<PointTable> table = ReadXyz("1 2 3\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->Find("nx"), nullptr);
}

TEST(XyzTest, ColorsAreNoNormals) {
  const absl::StatusOr<PointTable> table = ReadXyz("1 2 3 255 0 128\n4 5 6 0 0 0\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->Find("nx"), nullptr);
  EXPECT_THAT(Values(*table, "red"), ElementsAre(255, 0));
  EXPECT_THAT(Values(*table, "blue"), ElementsAre(128, 0));
}

// As in a PTS file: x y z intensity red green blue.
TEST(XyzTest, IntensityAndColorsAreNoNormals) {
  for (const char* rows : {"1 2 3 -1200 17 18 255\n4 5 6 0 0 0 0\n", "1 2 3 0 1 0 255\n4 5 6 0.5 200 0 0\n",
                           "1 2 3 255 128 0 0.6 0 0.8\n", "1 2 3 0 0 0 7\n"}) {
    const absl::StatusOr<PointTable> table = ReadXyz(rows);
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_EQ(table->Find("nx"), nullptr) << rows;
    EXPECT_NE(table->Find("column4"), nullptr) << rows;
  }
  // Rounded to a digit; of a point without a normal.
  EXPECT_NE(ReadXyz("1 2 3 0.6 0.6 0.6 9\n4 5 6 0 0 0 9\n")->Find("nx"), nullptr);
}

TEST(XyzTest, SixColumnsWithoutUnitVectorsHaveNoNormals) {
  for (const char* rows : {"1 2 3 65535 0 300\n4 5 6 0 0 0\n", "1 2 3 0.2 0.3 0.4\n4 5 6 1 0 0\n", "1 2 3 0 0 0\n"}) {
    const absl::StatusOr<PointTable> table = ReadXyz(rows);
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_EQ(table->Find("nx"), nullptr) << rows;
    EXPECT_NE(table->Find("column6"), nullptr) << rows;
    EXPECT_THAT(table->notes, ElementsAre(HasSubstr("columns 4 to 6 are no normals"))) << rows;
  }
  EXPECT_THAT(ReadXyz("1 2 3 0 0 1\n4 5 6 3 0.0 -4\n")->notes,
              ElementsAre(HasSubstr("the vector of point 1 has the length 5")));
  // Rounded ones, those of a point without a normal, and what a comment says.
  const absl::StatusOr<PointTable> rounded = ReadXyz("1 2 3 0.6 0.6 0.6\n4 5 6 0 0 0\n7 8 9 nan nan nan\n");
  EXPECT_NE(rounded->Find("nx"), nullptr);
  EXPECT_THAT(rounded->notes, ::testing::IsEmpty());
  EXPECT_NE(ReadXyz("# x y z nx ny nz\n1 2 3 0 3 4\n")->Find("nx"), nullptr);
}

TEST(XyzTest, RefusesDecimalCommas) {
  for (const char* row : {"0,25 1,5 3,75", "0,25;1,5;3,75", "1 2 3,5 0 0 1", "-1,5\t2,5\t-3,5e3"}) {
    EXPECT_THAT(Message(std::string("1 2 3\n") + row), HasSubstr("line 2: \"")) << row;
    EXPECT_THAT(Message(row), HasSubstr("seems to have decimal commas")) << row;
  }
  for (const char* row : {"1,2,3", "1, 2, 3", "1 ,2 ,3", "1,2,3;0,0,1", "1,2,3,\n", "1;2;3", "1,2,3 # 0,5"}) {
    EXPECT_THAT(Message(row), ::testing::Not(HasSubstr("decimal"))) << row;
  }
}

TEST(XyzTest, WholeNumbersUpToOneAreNormals) { EXPECT_NE(ReadXyz("1 2 3 0 0 1\n4 5 6 1 0 0\n")->Find("nx"), nullptr); }

TEST(XyzTest, AnEmptyFileIsAnEmptyCloud) {
  const absl::StatusOr<PointTable> table = ReadXyz("# nothing\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->size(), 0u);
  EXPECT_NE(table->Find("nz"), nullptr);
}

TEST(XyzTest, NamesLineAndValue) {
  EXPECT_THAT(Message("1 2 3\n1 2 x\n"), HasSubstr("line 2: value 3 (z) is \"x\""));
  EXPECT_THAT(Message("# c\n1 2 3 4 5 6\n1 2 3\n"), HasSubstr("line 3: expected 6 values, found 3"));
  EXPECT_THAT(Message("1 2\n"), HasSubstr("line 1: expected x y z nx ny nz"));
  EXPECT_THAT(Message("1 2 1e400\n"), HasSubstr("in the range of double"));
  EXPECT_THAT(Message(std::string("1 2 \x02\x01\n", 7)), HasSubstr("\"??\""));
}

TEST(XyzTest, TellsTextInUtf16) {
  const std::string text(
      "\xff\xfe"
      "1\0 \0"
      "2\0 \0"
      "3\0\n\0",
      14);
  EXPECT_THAT(Message(text), HasSubstr("line 1 has bytes of 0, as text in UTF-16 has: save it as UTF-8"));
}

TEST(XyzTest, TellsALineOfNames) {
  EXPECT_THAT(Message("x y z\n1 2 3\n"), HasSubstr("line 1: \"x y z\" looks like a line of names: put # before it"));
  EXPECT_THAT(Message("2\nX,Y,Z,Intensity\n1,2,3,4\n"), HasSubstr("line 2: \"X,Y,Z,Intensity\" looks like a line"));
  for (const char* file : {"1 2 3\nx y z\n", "x 2 3\n", "x y\n"}) {
    EXPECT_THAT(Message(file), ::testing::Not(HasSubstr("looks like"))) << file;
  }
  EXPECT_THAT(Message("1 2 x\n"), ::testing::EndsWith("is \"x\": expected a number"));
}

TEST(XyzTest, SurvivesTruncationAndDamage) {
  AcceptedPrefixes(ReadXyz, "2\n# c\n1.5 -2e3 +3 0 0 1\n4, 5; 6 nan inf 1\n");
}

TEST(XyzTest, RefusesMoreColumnsThanATableHolds) {
  std::string line;
  for (size_t i = 0; i <= kMaxColumns; ++i) line += "1 ";
  EXPECT_THAT(Message(line), HasSubstr("4097 values: expected at most 4096"));
}

TEST(XyzTest, TakesNamesFromTheCommentBeforeThePoints) {
  absl::StatusOr<PointTable> table = ReadXyz("# made by hand\n//X,Y,Z,k1,status,Nx\n2\n1 2 3 4 5 6\n1 2 3 4 5 255\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "k1"), ElementsAre(4, 4));
  EXPECT_THAT(Values(*table, "nx"), ElementsAre(6, 255));
  for (const char* comment : {"# x y z", "# x y z a b a", "# x and z of a b", "# x y z a b c d", "#"}) {
    table = ReadXyz(std::string(comment) + "\n1 2 3 0.6 0 0.8\n");
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_THAT(Values(*table, "nx"), ElementsAre(0.6)) << comment;
  }
  for (const char* comment : {"# id x y z a b", "# x z y a b c", "//z,y,x,a,b,c"}) {
    EXPECT_THAT(Message(std::string(comment) + "\n1 2 3 4.5 5 6\n"), HasSubstr("but does not begin with x y z"))
        << comment;
  }
}

}  // namespace
}  // namespace curv
