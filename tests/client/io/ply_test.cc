#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "client/io/formats.h"
#include "tests/client/io/samples.h"

namespace curv {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::string Message(const std::string& file) { return std::string(ReadPly(file).status().message()); }

std::string Header(const std::string& format, const std::string& body) {
  return "ply\nformat " + format + " 1.0\ncomment a test\n" + body + "end_header\n";
}

const std::string kTwoVertices =
    "element vertex 2\nproperty double x\nproperty float y\nproperty uchar tag\nproperty short s\n";

void ExpectTwoVertices(const absl::StatusOr<PointTable>& table) {
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "x"), ElementsAre(1.5, 4500000.125));
  EXPECT_THAT(Values(*table, "y"), ElementsAre(-2.0, 0.25));
  EXPECT_THAT(Values(*table, "tag"), ElementsAre(255, 7));
  EXPECT_THAT(Values(*table, "s"), ElementsAre(-300, 300));
  EXPECT_EQ(table->Find("x")->kind(), ScalarKind::kFloat64);
  EXPECT_EQ(table->Find("y")->kind(), ScalarKind::kFloat32);
  EXPECT_EQ(table->Find("tag")->kind(), ScalarKind::kUint8);
}

TEST(PlyTest, ReadsAscii) {
  ExpectTwoVertices(ReadPly(Header("ascii", kTwoVertices) + "1.5 -2 255 -300\r\n\n4500000.125 +.25 7 300"));
}

TEST(PlyTest, ReadsLittleEndian) {
  ExpectTwoVertices(ReadPly(Header("binary_little_endian", kTwoVertices) +
                            Pack(1.5, -2.0f, uint8_t{255}, int16_t{-300}) +
                            Pack(4500000.125, 0.25f, uint8_t{7}, int16_t{300})));
}

TEST(PlyTest, ReadsFilesWithAByteOrderMark) {
  ExpectTwoVertices(
      ReadPly("\xef\xbb\xbf" + Header("ascii", kTwoVertices) + "1.5 -2 255 -300\n4500000.125 .25 7 300\n"));
  ExpectTwoVertices(ReadPly("\xef\xbb\xbf" + Header("binary_little_endian", kTwoVertices) +
                            Pack(1.5, -2.0f, uint8_t{255}, int16_t{-300}) +
                            Pack(4500000.125, 0.25f, uint8_t{7}, int16_t{300})));
}

TEST(PlyTest, ReadsBigEndian) {
  ExpectTwoVertices(ReadPly(Header("binary_big_endian", kTwoVertices) +
                            PackSwapped(1.5, -2.0f, uint8_t{255}, int16_t{-300}) +
                            PackSwapped(4500000.125, 0.25f, uint8_t{7}, int16_t{300})));
}

TEST(PlyTest, ReadsEveryTypeUnderBothNames) {
  const absl::StatusOr<PointTable> table =
      ReadPly(Header("ascii",
                     "element vertex 1\nproperty char a\nproperty int8 b\nproperty ushort c\nproperty uint16 d\n"
                     "property int e\nproperty int32 f\nproperty uint g\nproperty uint32 h\nproperty float32 i\n"
                     "property float64 j\n") +
              "-128 -1 65535 1 -2147483648 5 4294967295 6 nan -inf\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "a"), ElementsAre(-128));
  EXPECT_THAT(Values(*table, "g"), ElementsAre(4294967295.0));
  EXPECT_TRUE(std::isnan(Values(*table, "i")[0]));
  EXPECT_THAT(Values(*table, "j"), ElementsAre(-INFINITY));
}

TEST(PlyTest, ReadsOverOtherElementsAndSaysSo) {
  const std::string body =
      "element camera 1\nproperty float f\nproperty list uchar int tags\nelement vertex 1\nproperty float x\n"
      "element face 1\nproperty list uchar int vertex_indices\n";
  for (const auto& [format, bytes] :
       {std::pair<std::string, std::string>{"ascii", "1 2 10 20\n5\n3 0 0 0\n"},
        {"binary_little_endian", Pack(1.0f, uint8_t{2}, 10, 20) + Pack(5.0f) + Pack(uint8_t{3}, 0, 0, 0)},
        {"binary_big_endian",
         PackSwapped(1.0f, uint8_t{2}, 10, 20) + PackSwapped(5.0f) + PackSwapped(uint8_t{3}, 0, 0, 0)}}) {
    const absl::StatusOr<PointTable> table = ReadPly(Header(format, body) + bytes);
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_THAT(Values(*table, "x"), ElementsAre(5.0)) << format;
    EXPECT_THAT(table->notes, ElementsAre(HasSubstr("camera"), HasSubstr("face")));
  }
}

TEST(PlyTest, LeavesOutListsOfVerticesAndSaysSo) {
  const std::string body = "element vertex 2\nproperty float x\nproperty list uchar short ring\nproperty float y\n";
  for (const auto& [format, bytes] : {std::pair<std::string, std::string>{"ascii", "1 2 7 8 3\n4 0 5\n"},
                                      {"binary_little_endian", Pack(1.0f, uint8_t{2}, int16_t{7}, int16_t{8}, 3.0f) +
                                                                   Pack(4.0f, uint8_t{0}, 5.0f)}}) {
    const absl::StatusOr<PointTable> table = ReadPly(Header(format, body) + bytes);
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_THAT(Values(*table, "x"), ElementsAre(1, 4));
    EXPECT_THAT(Values(*table, "y"), ElementsAre(3, 5));
    EXPECT_EQ(table->Find("ring"), nullptr);
    EXPECT_THAT(table->notes, ElementsAre(HasSubstr("ring")));
  }
}

TEST(PlyTest, ReadsACloudWithoutPoints) {
  const absl::StatusOr<PointTable> table = ReadPly(Header("ascii", "element vertex 0\nproperty float x\n"));
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->size(), 0u);
  EXPECT_NE(table->Find("x"), nullptr);
}

TEST(PlyTest, SurvivesTruncationAndDamage) {
  const std::string ascii = Header("ascii", kTwoVertices) + "1.5 -2 255 -300\n4.5 1 7 300\n";
  const std::string row = Pack(1.5, -2.0f, uint8_t{255}, int16_t{-300});
  // The prefix without the last line end is whole; nothing shorter is, but that numbers may lose digits.
  EXPECT_LE(AcceptedPrefixes(ReadPly, ascii), 3);
  EXPECT_EQ(AcceptedPrefixes(ReadPly, Header("binary_little_endian", kTwoVertices) + row + row), 0);
  EXPECT_EQ(AcceptedPrefixes(ReadPly, Header("binary_big_endian", kTwoVertices) + row + row), 0);
  const std::string lists = "element vertex 1\nproperty list int float f\nproperty uchar x\n";
  EXPECT_EQ(AcceptedPrefixes(ReadPly, Header("binary_little_endian", lists) + Pack(2, 1.0f, 2.0f, uint8_t{1})), 0);
}

TEST(PlyTest, NotesExtraBytes) {
  const std::string file = Header("binary_little_endian", kTwoVertices) + std::string(30, 'x');
  EXPECT_THAT(ReadPly(file)->notes, IsEmpty());
  EXPECT_THAT(ReadPly(file + "more")->notes, ElementsAre(HasSubstr("4 bytes")));
}

TEST(PlyTest, DoesNotTrustCounts) {
  const std::string huge = "element vertex 18446744073709551615\nproperty double x\n";
  EXPECT_THAT(Message(Header("binary_little_endian", huge) + "12345678"), HasSubstr("8 bytes are left"));
  EXPECT_THAT(Message(Header("ascii", huge) + "1\n"), HasSubstr("18446744073709551615 vertex lines"));
  const std::string list = "element vertex 1\nproperty list int double x\n";
  EXPECT_THAT(Message(Header("binary_little_endian", list) + Pack(int32_t{2147483647})), HasSubstr("ends within"));
  EXPECT_THAT(Message(Header("binary_little_endian", list) + Pack(int32_t{-1})), HasSubstr("length -1"));
}

TEST(PlyTest, NamesLineAndValue) {
  EXPECT_THAT(Message(Header("ascii", kTwoVertices) + "1 2 3 4\n1 2 256 4\n"),
              HasSubstr("line 11: value 3 (tag) is \"256\": expected an integer from 0 to 255"));
  EXPECT_THAT(Message(Header("ascii", kTwoVertices) + "1.5 2.5 3\n1.5 2.5 3 4\n"),
              HasSubstr("line 10: expected 4 values, found 3"));
  EXPECT_THAT(Message(Header("ascii", kTwoVertices) + "1 2 3 4 5\n1 2 3 4\n"),
              HasSubstr("line 10: expected 4 values, found 5"));
  EXPECT_THAT(Message(Header("ascii", kTwoVertices) + "1e999 2 3 4\n1 2 3 4\n"), HasSubstr("\"1e999\""));
  EXPECT_THAT(Message(Header("ascii", kTwoVertices) + "0x1 2 3 4\n1 2 3 4\n"), HasSubstr("\"0x1\""));
}

TEST(PlyTest, TakesTinyNumbersAsZero) {
  const absl::StatusOr<PointTable> table =
      ReadPly(Header("ascii", "element vertex 1\nproperty double x\nproperty float y\n") + "1e-999 -1e-99\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "x"), ElementsAre(0.0));
  EXPECT_THAT(Values(*table, "y"), ElementsAre(0.0));
}

TEST(PlyTest, TakesBlanksAtTheEndsOfHeaderLines) {
  const absl::StatusOr<PointTable> table = ReadPly(
      "ply \t\nformat ascii 1.0 \nelement vertex 1\t\nproperty float x  \nproperty float y\t \nend_header \n1.5 2.5\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "x"), ElementsAre(1.5));
  EXPECT_THAT(Values(*table, "y"), ElementsAre(2.5));
}

TEST(PlyTest, RefusesBadHeaders) {
  EXPECT_THAT(Message("ply x\n"), HasSubstr("line 1: expected the word ply"));
  EXPECT_THAT(Message(""), HasSubstr("line 1: expected the word ply"));
  EXPECT_THAT(Message("plyx\n"), HasSubstr("line 1"));
  EXPECT_THAT(Message("ply\nformat ascii 1.0\nelement vertex 1\n"), HasSubstr("expected end_header"));
  EXPECT_THAT(Message("ply\nelement vertex 0\nend_header\n"), HasSubstr("names no format"));
  EXPECT_THAT(Message("ply\nformat utf8 1.0\n"), HasSubstr("line 2: unknown format \"utf8\""));
  EXPECT_THAT(Message("ply\nformat ascii 2.0\n"), HasSubstr("unknown version \"2.0\""));
  EXPECT_THAT(Message(Header("ascii", "element vertex -1\n")), HasSubstr("\"-1\""));
  EXPECT_THAT(Message(Header("ascii", "property float x\n")), HasSubstr("before any element"));
  EXPECT_THAT(Message(Header("ascii", "element vertex 1\nproperty half x\n")), HasSubstr("unknown type \"half\""));
  EXPECT_THAT(Message(Header("ascii", "element vertex 1\nproperty list float int x\n")), HasSubstr("integer type"));
  EXPECT_THAT(Message(Header("ascii", "element vertex 1\nproperty float x\nproperty int x\n")), HasSubstr("twice"));
  EXPECT_THAT(Message(Header("ascii", "element face 0\n")), HasSubstr("no element vertex"));
}

TEST(PlyTest, RefusesVerticesWithoutAProperty) {
  for (const char* format : {"ascii", "binary_little_endian"}) {
    EXPECT_THAT(Message(Header(format, "element vertex 1152921504606846976\n")),
                HasSubstr("1152921504606846976 vertices without a property"));
  }
}

TEST(PlyTest, ShowsNoNameThatATerminalObeys) {
  const std::string element = "element \x1b[2J 1\nproperty list char int \x1b[2J\n";
  EXPECT_THAT(Message(Header("binary_little_endian", element) + "\xff"), HasSubstr("list ?[2J of ?[2J 0"));
  EXPECT_THAT(Message(Header("binary_little_endian", element)), HasSubstr("1 ?[2J rows"));
  EXPECT_THAT(Message(Header("ascii", element)), HasSubstr("1 ?[2J lines"));
  const absl::StatusOr<PointTable> table =
      ReadPly(Header("ascii", "element vertex 1\nproperty list char int \x1b[2J\n" + element) + "0\n0\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(table->notes, ElementsAre(HasSubstr("property ?[2J"), HasSubstr("element ?[2J")));
}

TEST(PlyTest, RefusesMorePropertiesThanATableHolds) {
  std::string vertex = "element vertex 0\n";
  for (size_t i = 0; i <= kMaxColumns; ++i) vertex += "property float p" + std::to_string(i) + "\n";
  EXPECT_THAT(Message(Header("ascii", vertex)), HasSubstr("more than 4096 properties"));
}

TEST(PlyNamesTest, CloudComparesScalarFieldsComeBackUnderTheirNames) {
  const auto table = ReadPly(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property float scalar_k1\nproperty float scalar_status\nproperty float scalar_x\nproperty float scalar_\n"
      "end_header\n1 2 3 0.5 1 7 8\n4 5 6 -0.5 7 7 8\n");
  ASSERT_TRUE(table.ok()) << table.status();
  std::vector<std::string> names;
  for (const Column& column : table->columns()) names.push_back(column.name);
  EXPECT_THAT(names, ::testing::ElementsAre("x", "y", "z", "k1", "status", "scalar_x", "scalar_"));
  EXPECT_EQ(table->Find("status")->kind(), ScalarKind::kUint8);
  EXPECT_EQ(table->Find("status")->At(1), 7.0);
}

TEST(PlyNamesTest, AStatusThatIsNoByteStaysAFloat) {
  const auto table =
      ReadPly("ply\nformat ascii 1.0\nelement vertex 2\nproperty float scalar_status\nend_header\n1\n1.5\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->Find("status")->kind(), ScalarKind::kFloat32);
}

TEST(PlyTest, RefusesTwoPropertiesOfOneName) {
  const absl::Status status = ReadPly(
                                  "ply\nformat ascii 1.0\nelement vertex 1\nproperty float nx\nproperty float "
                                  "NormalX\nend_header\n1 2\n")
                                  .status();
  EXPECT_THAT(std::string(status.message()), HasSubstr("line 6: two properties have the name \"nx\""));
}

}  // namespace
}  // namespace curv
