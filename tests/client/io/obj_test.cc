#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <variant>
#include <vector>

#include "client/io/formats.h"
#include "tests/client/io/samples.h"

namespace curv {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsNan;

std::string Message(const std::string& file) { return std::string(ReadObj(file).status().message()); }

TEST(ObjTest, PairsInOrder) {
  const absl::StatusOr<PointTable> table =
      ReadObj("# c\no thing\nv 1 2 3 1.0\nvn 0 0 1\nv 4 5 6 1.0\nvn 1 0 0\nvt 0 0\nf 1 2 1\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "x"), ElementsAre(1, 4));
  EXPECT_THAT(Values(*table, "nx"), ElementsAre(0, 1));
}

TEST(ObjTest, ReadsFilesWithAByteOrderMark) {
  const absl::StatusOr<PointTable> table = ReadObj("\xef\xbb\xbfv 1 2 3\nvn 0 0 1\nv 4 5 6\nvn 1 0 0\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "x"), ElementsAre(1, 4));
}

TEST(ObjTest, PairsByFaces) {
  const absl::StatusOr<PointTable> table =
      ReadObj("v 1 0 0\nv 2 0 0\nv 3 0 0\nvn 0 0 1\nvn 0 1 0\nf 1//2 2/7/1 -1//-2\nf 1//1 2//1 3//1\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "ny"), ElementsAre(DoubleEq(std::sqrt(0.5)), 0, 0));
  EXPECT_THAT(Values(*table, "nz"), ElementsAre(DoubleEq(std::sqrt(0.5)), 1, 1)) << "whatever the number of faces";
}

TEST(ObjTest, VerticesWithoutFaceHaveNoNormal) {
  const absl::StatusOr<PointTable> table =
      ReadObj("v 1 0 0\nvn 0 0 1\nf 1//1\nv 2 0 0\nv 3 0 0\nvn 0 0 -1\nf 3//1 3//2\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "nz"), ElementsAre(1, IsNan(), IsNan())) << "nor have those whose normals cancel";
}

TEST(ObjTest, ReadsColors) {
  absl::StatusOr<PointTable> table = ReadObj("v 1 2 3 0 0.5 1\nv 4 5 6 1 0.2 0 # red\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "red"), ElementsAre(0, 255));
  EXPECT_THAT(Values(*table, "green"), ElementsAre(128, 51));
  EXPECT_EQ(table->Find("blue")->kind(), ScalarKind::kUint8);
  EXPECT_THAT(Values(*ReadObj("v 1 2 3 0 17 255\n"), "green"), ElementsAre(17));
  EXPECT_THAT(Values(*ReadObj("v 1 2 3 0 1.5 65535\n"), "blue"), ElementsAre(65535));
  table = ReadObj("v 1 2 3 0 0.5 1\nv 4 5 6\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->Find("red"), nullptr);
  EXPECT_THAT(table->notes, ElementsAre("left out the colors: 1 of 2 v lines has one"));
}

TEST(ObjTest, RefusesWhatFollowsTheCoordinates) {
  EXPECT_THAT(Message("v 1 2 3 junk\n"), HasSubstr("line 1: v has \"junk\" after x y z: expected"));
  EXPECT_THAT(Message("v 1 2 3 4 5\n"), HasSubstr("2 numbers after x y z"));
  EXPECT_THAT(Message("v 1 2 3 4 5 6 7\n"), HasSubstr("4 or more numbers after x y z"));
  EXPECT_THAT(Message("v 1 2 3\nvn 0 0 1 0\n"), HasSubstr("line 2: vn has \"0\" after its three numbers"));
  EXPECT_TRUE(ReadObj("v 1 2 3 # w is 1\nvn 0 0 1 #\n").ok());
}

TEST(ObjTest, LeavesOutNormalsThatDoNotCorrespond) {
  const absl::StatusOr<PointTable> table = ReadObj("v 1 0 0\nv 2 0 0\nvn 0 0 1\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->Find("nx"), nullptr);
  EXPECT_THAT(table->notes, ElementsAre(HasSubstr("1 vn lines do not correspond to 2 v lines")));
}

TEST(ObjTest, NamesLineAndValue) {
  EXPECT_THAT(Message("v 1 2\n"), HasSubstr("line 1: v needs three numbers, found \"\""));
  EXPECT_THAT(Message("v 1 2 3\nvn a 2 3\n"), HasSubstr("line 2: vn needs three numbers, found \"a\""));
  EXPECT_THAT(Message("v 1 2 3\nvn 0 0 1\nf 1//2\n"), HasSubstr("line 3: face corner \"1//2\""));
  EXPECT_THAT(Message("v 1 2 3\nvn 0 0 1\nf 0//1\n"), HasSubstr("does not exist"));
  EXPECT_THAT(Message("v 1 2 3\nvn 0 0 1\nf -9223372036854775808//1\n"), HasSubstr("does not exist"));
  EXPECT_THAT(Message("v 1 2 3\nvn 0 0 1\nf x//1\n"), HasSubstr("expected integers"));
  EXPECT_THAT(Message("vn 0 0 1\n"), HasSubstr("no v lines"));
}

TEST(ObjTest, LinesGoOnAfterABackslash) {
  const auto table = ReadObj("v 1 2 \\\n3\nv 4 \\\r\n5 \\\r\n6\nv 7 8 9\\");
  ASSERT_TRUE(table.ok()) << table.status();
  ASSERT_EQ(table->size(), 3u);
  EXPECT_EQ(std::get<std::vector<double>>(table->Find("z")->values), (std::vector<double>{3, 6, 9}));
}

TEST(ObjTest, SurvivesTruncationAndDamage) {
  AcceptedPrefixes(ReadObj, "v 1 2 3\nvn 0 0 1\nv 4 5 6\nvn 1 0 0\nf 1//1 2/3/2 -1//-1\n");
}

}  // namespace
}  // namespace curv
