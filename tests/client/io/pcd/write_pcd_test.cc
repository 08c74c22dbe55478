#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "client/io/formats.h"
#include "client/io/table_file.h"
#include "client/io/writing/table_stream.h"
#include "tests/client/io/samples.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;

PointTable Colored() {
  PointTable table;
  table.Set({"x", std::vector<float>{1, 2}});
  table.Set({"green", std::vector<uint8_t>{200, 0}});
  table.Set({"red", std::vector<uint8_t>{255, 16}});
  table.Set({"y", std::vector<float>{3, 4}});
  table.Set({"blue", std::vector<uint8_t>{7, 255}});
  return table;
}

// The columns of each file that curv writes of the table, as it reads them again.
void ExpectSame(const PointTable& table, const std::vector<std::string>& names) {
  const TempDir dir;
  for (const bool ascii : {false, true}) {
    ASSERT_TRUE(SaveTable(table, dir.File("t.pcd"), {.ascii = ascii}).ok());
    const absl::StatusOr<PointTable> read = LoadTable(dir.File("t.pcd"));
    ASSERT_TRUE(read.ok()) << read.status();
    ASSERT_EQ(read->columns().size(), table.columns().size());
    for (const std::string& name : names) EXPECT_EQ(read->Find(name)->values, table.Find(name)->values) << name;
    auto stream = TableStream::Create(dir.File("s.pcd"), {.ascii = ascii}, table, table.size());
    ASSERT_TRUE(stream.ok() && (*stream)->Append(table).ok() && (*stream)->Commit().ok());
    EXPECT_EQ(dir.Read("s.pcd"), dir.Read("t.pcd"));
  }
}

TEST(WritePcdTest, PacksColorsAsPclDoes) {
  const TempDir dir;
  ASSERT_TRUE(SaveTable(Colored(), dir.File("t.pcd"), {}).ok());
  EXPECT_THAT(dir.Read("t.pcd"), HasSubstr("FIELDS x rgb y\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"));
  EXPECT_THAT(dir.Read("t.pcd"),
              EndsWith("DATA binary\n" + Pack(1.0f, 0xffffc807, 3.0f) + Pack(2.0f, 0xff1000ff, 4.0f)));
  ASSERT_TRUE(SaveTable(Colored(), dir.File("a.pcd"), {.ascii = true}).ok());
  EXPECT_THAT(dir.Read("a.pcd"), HasSubstr("TYPE F U F\n"));
  EXPECT_THAT(dir.Read("a.pcd"), EndsWith("DATA ascii\n1 4294952967 3\n2 4279238911 4\n"));
  ExpectSame(Colored(), {"x", "red", "green", "blue", "y"});
}

TEST(WritePcdTest, PacksOpacityToo) {
  PointTable table = Colored();
  table.Set({"alpha", std::vector<uint8_t>{0, 128}});
  const TempDir dir;
  ASSERT_TRUE(SaveTable(table, dir.File("t.pcd"), {}).ok());
  EXPECT_THAT(dir.Read("t.pcd"), HasSubstr("FIELDS x rgba y\nSIZE 4 4 4\nTYPE F U F\n"));
  ExpectSame(table, {"red", "green", "blue", "alpha"});
}

TEST(WritePcdTest, LeavesOtherColorsAsTheyAre) {
  PointTable wide = Colored();
  wide.Set({"red", std::vector<uint16_t>{65535, 16}});
  ExpectSame(wide, {"red", "green", "blue"});
  PointTable taken = Colored();
  taken.Set({"rgb", std::vector<float>{0.5f, 1.5f}});
  ExpectSame(taken, {"red", "green", "blue", "rgb"});
}

TEST(WritePcdTest, KeepsWhereTheSensorWasAndTheGrid) {
  const TempDir dir;
  const std::string fields = "FIELDS x\nSIZE 4\nTYPE F\nCOUNT 1\nWIDTH 3\nHEIGHT 2\n";
  const std::string rest = "POINTS 6\nDATA ascii\n1\n2\n3\n4\n5\n6\n";
  for (const char* viewpoint : {"VIEWPOINT 1.5 -2 3 0.5 0.5 -0.5 0.5\n", "VIEWPOINT 0 0 0 0 1 0 0\n"}) {
    const absl::StatusOr<PointTable> table = ReadPcd(fields + viewpoint + rest);
    ASSERT_TRUE(table.ok()) << table.status();
    ASSERT_TRUE(SaveTable(*table, dir.File("t.pcd"), {.ascii = true}).ok());
    EXPECT_THAT(dir.Read("t.pcd"), EndsWith("WIDTH 3\nHEIGHT 2\n" + (viewpoint + rest)));
  }
}

TEST(WritePcdTest, GivesNoGridToOtherNumbersOfPoints) {
  PointTable table = Colored();
  table.pcd.width = table.pcd.height = 2;
  const TempDir dir;
  ASSERT_TRUE(SaveTable(table, dir.File("t.pcd"), {}).ok());
  EXPECT_THAT(dir.Read("t.pcd"), HasSubstr("WIDTH 2\nHEIGHT 1\n"));
}

TEST(WritePcdTest, SaysWhatOtherFormatsHaveNoPlaceFor) {
  PointTable table = Colored();
  EXPECT_EQ(NoteOnFrame(table, ".ply"), "");
  table.viewpoint = {1.5, -2.0, 0.0};
  EXPECT_EQ(NoteOnFrame(table, ".pcd"), "");
  EXPECT_EQ(NoteOnFrame(table, ".ply"), "left out the viewpoint 1.5,-2,0, for which only .pcd has a place");
  table.pcd.width = 640, table.pcd.height = 480;
  EXPECT_THAT(NoteOnFrame(table, ".las"), HasSubstr("1.5,-2,0 and the grid of 640 x 480 points, for which"));
}

}  // namespace
}  // namespace curv
