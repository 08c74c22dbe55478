#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lzf.h>

#include "client/io/formats.h"
#include "tests/client/io/samples.h"

namespace curv {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string Message(const std::string& file) { return std::string(ReadPcd(file).status().message()); }

std::string Header(const std::string& data, const std::string& points = "2") {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x normal_x ring\nSIZE 4 8 2\nTYPE F F U\nCOUNT 1 1 1\nWIDTH " + points +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + points + "\nDATA " + data + "\n";
}

std::string Compressed(const std::string& plain) {
  std::string packed(plain.size() + 64, '\0');
  const unsigned size = lzf_compress(plain.data(), static_cast<unsigned>(plain.size()), packed.data(),
                                     static_cast<unsigned>(packed.size()));
  EXPECT_GT(size, 0u);
  packed.resize(size);
  return Pack(static_cast<uint32_t>(size), static_cast<uint32_t>(plain.size())) + packed;
}

void ExpectTwoPoints(const absl::StatusOr<PointTable>& table) {
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "x"), ElementsAre(1.5, -2.5));
  EXPECT_THAT(Values(*table, "nx"), ElementsAre(0.25, 0.5));
  EXPECT_THAT(Values(*table, "ring"), ElementsAre(65535, 3));
}

const std::string kRows = Pack(1.5f, 0.25, uint16_t{65535}) + Pack(-2.5f, 0.5, uint16_t{3});
const std::string kColumns = Pack(1.5f, -2.5f) + Pack(0.25, 0.5) + Pack(uint16_t{65535}, uint16_t{3});

TEST(PcdTest, ReadsFilesWithAByteOrderMark) {
  ExpectTwoPoints(ReadPcd("\xef\xbb\xbf" + Header("ascii") + "1.5 0.25 65535\n-2.5 0.5 3\n"));
  ExpectTwoPoints(ReadPcd("\xef\xbb\xbf" + Header("binary") + kRows));
}

TEST(PcdTest, TakesAViewpointThatSomebodySet) {
  const auto viewpoint = [](const std::string& words) {
    std::string file = Header("ascii") + "1.5 0.25 65535\n-2.5 0.5 3\n";
    file.replace(file.find("0 0 0 1 0 0 0"), std::string("0 0 0 1 0 0 0").size(), words);
    const absl::StatusOr<PointTable> table = ReadPcd(file);
    EXPECT_TRUE(table.ok()) << table.status();
    return table->viewpoint;
  };
  EXPECT_EQ(viewpoint("1.5 -2 1e3 1 0 0 0"), (std::array<double, 3>{1.5, -2.0, 1000.0}));
  EXPECT_EQ(viewpoint("0 0 0 1 0 0 0"), std::nullopt) << "which writers say who do not know it";
  for (const char* words : {"", "1 2", "1 nan 3 1 0 0 0", "here"}) EXPECT_EQ(viewpoint(words), std::nullopt) << words;
}

TEST(PcdTest, ReadsAscii) { ExpectTwoPoints(ReadPcd(Header("ascii") + "1.5 0.25 65535\n-2.5 0.5 3\n")); }

TEST(PcdTest, ReadsBinary) { ExpectTwoPoints(ReadPcd(Header("binary") + kRows)); }

TEST(PcdTest, ReadsBinaryCompressed) { ExpectTwoPoints(ReadPcd(Header("binary_compressed") + Compressed(kColumns))); }

TEST(PcdTest, ReadsLongCompressedRuns) {
  std::string columns;
  for (int column = 0; column < 3; ++column) columns.append(1000 * (column == 0 ? 4 : column == 1 ? 8 : 2), '\0');
  const absl::StatusOr<PointTable> table = ReadPcd(Header("binary_compressed", "1000") + Compressed(columns));
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->size(), 1000u);
}

TEST(PcdTest, SurvivesTruncationAndDamage) {
  EXPECT_LE(AcceptedPrefixes(ReadPcd, Header("ascii") + "1.5 0.25 65535\n-2.5 0.5 3\n"), 1);
  EXPECT_EQ(AcceptedPrefixes(ReadPcd, Header("binary") + kRows), 0);
  EXPECT_EQ(AcceptedPrefixes(ReadPcd, Header("binary_compressed") + Compressed(kColumns)), 0);
}

TEST(PcdTest, LeavesOutPaddingAndVectors) {
  const std::string file =
      "FIELDS x _ fpfh y\nSIZE 4 1 4 4\nTYPE F U F F\nCOUNT 1 4 2 1\nWIDTH 1\nHEIGHT 1\nDATA binary\n" +
      Pack(1.0f, 0, 8.0f, 9.0f, 2.0f);
  const absl::StatusOr<PointTable> table = ReadPcd(file);
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "x"), ElementsAre(1.0));
  EXPECT_THAT(Values(*table, "y"), ElementsAre(2.0));
  EXPECT_EQ(table->columns().size(), 2u);
  EXPECT_THAT(table->notes, ElementsAre(HasSubstr("fpfh")));
}

TEST(PcdTest, TurnsLongIntegersIntoDoubles) {
  const std::string file =
      "FIELDS t u\nSIZE 8 8\nTYPE I U\nCOUNT 1 1\nPOINTS 1\nDATA binary\n" + Pack(int64_t{-5}, ~uint64_t{0});
  const absl::StatusOr<PointTable> table = ReadPcd(file);
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "t"), ElementsAre(-5.0));
  EXPECT_THAT(Values(*table, "u"), ElementsAre(0x1p64));
  EXPECT_THAT(table->notes, ElementsAre(HasSubstr("column u is rounded: integers beyond 2^53")));
  const absl::StatusOr<PointTable> text =
      ReadPcd("FIELDS t u\nSIZE 8 8\nTYPE I U\nPOINTS 1\nDATA ascii\n-9007199254740993 9007199254740994\n");
  ASSERT_TRUE(text.ok()) << text.status();
  EXPECT_THAT(text->notes, ElementsAre(HasSubstr("column t is rounded")));
}

TEST(PcdTest, UnpacksColors) {
  const auto head = [](const std::string& field, char type, const std::string& data) {
    return "FIELDS x " + field + "\nSIZE 4 4\nTYPE F " + type + "\nPOINTS 2\nDATA " + data + "\n";
  };
  // 0xff7f8081 is not NaN, 0xffffc807 and 0xff80a0c0 are, the latter a signaling one.
  const std::string rows = Pack(1.0f, 0xffffc807) + Pack(2.0f, 0xff80a0c0);
  for (const std::string& file :
       {head("rgb", 'F', "binary") + rows, head("rgb", 'U', "binary") + rows, head("rgba", 'I', "binary") + rows,
        head("rgb", 'F', "binary_compressed") + Compressed(Pack(1.0f, 2.0f, 0xffffc807, 0xff80a0c0)),
        head("rgb", 'U', "ascii") + "1 4294952967\n2 4286619840\n",
        head("rgb", 'I', "ascii") + "1 -14329\n2 -8347456\n"}) {
    const absl::StatusOr<PointTable> table = ReadPcd(file);
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_THAT(Values(*table, "red"), ElementsAre(255, 128));
    EXPECT_THAT(Values(*table, "green"), ElementsAre(200, 160));
    EXPECT_THAT(Values(*table, "blue"), ElementsAre(7, 192));
    EXPECT_EQ(table->Find("red")->kind(), ScalarKind::kUint8);
    EXPECT_EQ(table->Find("rgb"), nullptr);
    EXPECT_EQ(table->Find("alpha") != nullptr, file.find("rgba") != std::string::npos);
  }
  const absl::StatusOr<PointTable> floats = ReadPcd(head("rgb", 'F', "ascii") + "1 2.3418052e-38\n2 9.809e-45\n");
  ASSERT_TRUE(floats.ok()) << floats.status();
  EXPECT_THAT(Values(*floats, "red"), ElementsAre(255, 0)) << "0x00ff0000";
  EXPECT_THAT(Values(*floats, "blue"), ElementsAre(0, 7)) << "0x00000007";
}

TEST(PcdTest, TakesIntegersInTextForPackedColors) {
  const absl::StatusOr<PointTable> table =
      ReadPcd("FIELDS x rgb\nSIZE 4 4\nTYPE F F\nPOINTS 3\nDATA ascii\n1 16711680\n2 0\n3 4294952967\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(Values(*table, "red"), ElementsAre(255, 0, 255));
  EXPECT_THAT(Values(*table, "blue"), ElementsAre(0, 0, 7)) << "which a float would have rounded";
}

TEST(PcdTest, LeavesOutColorsThatTextHasLost) {
  for (const char* rows : {"1 nan\n2 1e-38\n", "1 7\n2 0.5\n", "1 7\n2 4294967296\n"}) {
    const absl::StatusOr<PointTable> table =
        ReadPcd(std::string("FIELDS x rgb\nSIZE 4 4\nTYPE F F\nPOINTS 2\nDATA ascii\n") + rows);
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_EQ(table->columns().size(), 1u);
    EXPECT_THAT(table->notes, ElementsAre(HasSubstr("left out field rgb: text does not say which colors")));
  }
}

TEST(PcdTest, TellsOfWhatFollowsTheLastPoint) {
  const std::string text = "1.5 0.25 65535\n-2.5 0.5 3\n";
  for (const std::string& file : {Header("ascii") + text + "7 8 9\n", Header("binary") + kRows + "more",
                                  Header("binary_compressed") + Compressed(kColumns) + "more"}) {
    const absl::StatusOr<PointTable> table = ReadPcd(file);
    ExpectTwoPoints(table);
    EXPECT_THAT(table->notes, ElementsAre(HasSubstr(" bytes after the last point")));
  }
  EXPECT_TRUE(ReadPcd(Header("ascii") + text + "\n \n")->notes.empty());
  EXPECT_TRUE(ReadPcd(Header("binary") + kRows + std::string(8, '\0'))->notes.empty());
}

TEST(PcdTest, KeepsPackedColorsBesideOthers) {
  for (const std::string other : {"red", "rgba"}) {
    const absl::StatusOr<PointTable> table =
        ReadPcd("FIELDS rgb " + other + "\nSIZE 4 4\nTYPE U U\nPOINTS 1\n" + "DATA ascii\n65536 7\n");
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_THAT(Values(*table, "rgb"), ElementsAre(65536));
    EXPECT_THAT(Values(*table, other), ElementsAre(7));
  }
}

TEST(PcdTest, DoesNotTrustCounts) {
  EXPECT_THAT(Message(Header("binary", "18446744073709551615") + kRows), HasSubstr("28 bytes follow"));
  EXPECT_THAT(Message(Header("ascii", "3") + "1 2 3\n"), HasSubstr("after 1 of 3 points"));
  EXPECT_THAT(Message(Header("binary_compressed", "100000000") + Pack(1u, 1400000000u) + "x"),
              HasSubstr("cannot hold"));
  EXPECT_THAT(Message(Header("binary_compressed") + Pack(9u, 27u) + "123456789"), HasSubstr("27 decompressed"));
  EXPECT_THAT(Message(Header("binary_compressed") + Pack(9u, 28u) + std::string(9, '\xff')), HasSubstr("damaged"));
  EXPECT_THAT(Message("FIELDS x\nSIZE 4\nTYPE F\nCOUNT 4294967295\nPOINTS 1\nDATA ascii\n1\n"),
              HasSubstr("at most 65536"));
  EXPECT_THAT(Message("FIELDS x\nWIDTH 18446744073709551615\nHEIGHT 2\nDATA ascii\n1\n"), HasSubstr("too large"));
}

TEST(PcdTest, RefusesBadHeaders) {
  EXPECT_THAT(Message(""), HasSubstr("expected DATA"));
  EXPECT_THAT(Message("DATA ascii\n"), HasSubstr("no FIELDS"));
  EXPECT_THAT(Message("FIELDS x\nDATA ascii\n"), HasSubstr("neither POINTS nor WIDTH"));
  EXPECT_THAT(Message("FIELDS x y\nSIZE 4\nDATA ascii\n"), HasSubstr("line 2: SIZE of field y"));
  EXPECT_THAT(Message("FIELDS x\nSIZE 4 4\nDATA ascii\n"), HasSubstr("more values than the 1 FIELDS"));
  EXPECT_THAT(Message("FIELDS x\nTYPE D\nPOINTS 1\nDATA ascii\n"), HasSubstr("TYPE D"));
  EXPECT_THAT(Message("FIELDS x\nSIZE 3\nTYPE I\nPOINTS 1\nDATA ascii\n"), HasSubstr("SIZE 3"));
  EXPECT_THAT(Message("FIELDS x\nPOINTS many\n"), HasSubstr("\"many\""));
  EXPECT_THAT(Message("FIELDS x\nPOINTS 1\nDATA zip\n"), HasSubstr("\"zip\""));
  EXPECT_THAT(Message("BOUNDS 1 2\n"), HasSubstr("unknown keyword \"BOUNDS\""));
}

// One of them would be read, and nobody knows which was meant.
TEST(PcdTest, RefusesTwoFieldsOfOneName) {
  EXPECT_THAT(Message("FIELDS x y z i i\nPOINTS 1\nDATA ascii\n1 2 3 4 5\n"),
              HasSubstr("line 3: two FIELDS have the name \"i\""));
  EXPECT_THAT(Message("FIELDS x y z nx normal_x\nPOINTS 1\nDATA ascii\n1 2 3 4 5\n"),
              HasSubstr("two FIELDS have the name \"nx\": \"nx\" and \"normal_x\": rename or remove one"));
  EXPECT_TRUE(ReadPcd("FIELDS x _ _ y\nPOINTS 1\nDATA ascii\n1 2 3 4\n").ok());
}

TEST(PcdTest, ShowsNoNameThatATerminalObeys) {
  EXPECT_THAT(Message("FIELDS \x1b[2J\nSIZE x\n"), HasSubstr("SIZE of field ?[2J is"));
  EXPECT_THAT(Message("FIELDS \x1b[2J\nTYPE \x1b\nPOINTS 1\nDATA ascii\n"), HasSubstr("field ?[2J has TYPE ?,"));
  const absl::StatusOr<PointTable> table = ReadPcd("FIELDS \x1b[2J\nCOUNT 2\nPOINTS 1\nDATA ascii\n1 2\n");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(table->notes, ElementsAre(HasSubstr("field ?[2J: it has")));
}

TEST(PcdTest, RefusesMoreFieldsThanATableHolds) {
  std::string fields = "FIELDS";
  for (size_t i = 0; i <= kMaxColumns; ++i) fields += " f";
  EXPECT_THAT(Message(fields + "\nPOINTS 0\nDATA ascii\n"), HasSubstr("4097 FIELDS: expected at most 4096"));
}

}  // namespace
}  // namespace curv
