#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "client/io/table_file.h"
#include "tests/client/io/samples.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

PointTable Sample() {
  PointTable table;
  table.Set({"x", std::vector<double>{4500000.123456789, -0.0, 1e-300}});
  table.Set({"y", std::vector<float>{0.1f, 2, 3}});
  table.Set({"z", std::vector<int16_t>{-5, 7, 32767}});
  table.Set({"nx", std::vector<float>{0, 1, 0}});
  table.Set({"ny", std::vector<float>{1, 0, 0}});
  table.Set({"nz", std::vector<float>{0, 0, 1}});
  table.Set({"k1", std::vector<float>{0.1f, std::numeric_limits<float>::quiet_NaN(),
                                      -std::numeric_limits<float>::infinity()}});
  table.Set({"status", std::vector<uint8_t>{1, 4, 5}});
  return table;
}

void ExpectSame(const PointTable& expected, const PointTable& actual, bool kinds) {
  ASSERT_EQ(actual.columns().size(), expected.columns().size());
  for (size_t c = 0; c < expected.columns().size(); ++c) {
    const Column &a = expected.columns()[c], &b = actual.columns()[c];
    EXPECT_EQ(a.name, b.name);
    if (kinds) {
      EXPECT_EQ(a.kind(), b.kind()) << a.name;
    }
    for (size_t i = 0; i < a.size(); ++i) {
      const double want = a.At(i), got = a.kind() == ScalarKind::kFloat32 ? static_cast<float>(b.At(i)) : b.At(i);
      EXPECT_TRUE(want == got || (std::isnan(want) && std::isnan(got))) << a.name << " " << want << " " << got;
    }
  }
}

TEST(TextWritersTest, ComeBackInTheirDigits) {
  const TempDir dir;
  PointTable table = Sample();
  table.viewpoint = {4500000.123456789, 0.5, -2};
  for (const char* name : {"t.pcd", "t.ply", "t.xyz"}) {
    for (const bool ascii : {false, true}) {
      ASSERT_TRUE(SaveTable(table, dir.File(name), {.ascii = ascii}).ok());
      const absl::StatusOr<PointTable> read = LoadTable(dir.File(name));
      ASSERT_TRUE(read.ok()) << read.status();
      ExpectSame(table, *read, /*kinds=*/std::string(name) != "t.xyz");
      if (std::string(name) == "t.pcd") {
        EXPECT_EQ(read->viewpoint, table.viewpoint);
      }
    }
  }
}

TEST(TextWritersTest, NamesKeepTheirLetters) {
  const TempDir dir;
  PointTable table;
  for (const char* name : {"x", "y", "z", "h\u00f6he", "\u9ad8\u3055"}) table.Set({name, std::vector<float>{1, 2}});
  table.Set({"echo \u00f6,\x7f", std::vector<float>{3, 4}});
  for (const char* file : {"t.ply", "t.pcd", "t.xyz", "t.csv"}) {
    ASSERT_TRUE(SaveTable(table, dir.File(file)).ok());
    const absl::StatusOr<PointTable> read = LoadTable(dir.File(file));
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_NE(read->Find("h\u00f6he"), nullptr) << file;
    EXPECT_NE(read->Find("\u9ad8\u3055"), nullptr) << file;
    EXPECT_NE(read->Find("echo_\u00f6__"), nullptr) << file;
  }
}

// Readers take the first columns for x y z.
TEST(TextWritersTest, XyzHasPositionsFirst) {
  const TempDir dir;
  PointTable table;
  for (const char* name : {"id", "z", "x", "y"}) table.Set({name, std::vector<double>{static_cast<double>(*name)}});
  ASSERT_TRUE(SaveTable(table, dir.File("t.xyz")).ok());
  EXPECT_EQ(dir.Read("t.xyz"), "# x y z id\n120 121 122 105\n");
  const absl::StatusOr<PointTable> read = LoadTable(dir.File("t.xyz"));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(Values(*read, "id"), std::vector<double>{105});
}

TEST(TextWritersTest, WriteWhatOthersRead) {
  const TempDir dir;
  PointTable table = Sample();
  ASSERT_TRUE(SaveTable(table, dir.File("t.pcd"), {.ascii = true}).ok());
  EXPECT_EQ(dir.Read("t.pcd"),
            "# .PCD v0.7 - made by curv\n"
            "VERSION 0.7\n"
            "FIELDS x y z normal_x normal_y normal_z k1 status\n"
            "SIZE 8 4 2 4 4 4 4 1\n"
            "TYPE F F I F F F F U\n"
            "COUNT 1 1 1 1 1 1 1 1\n"
            "WIDTH 3\n"
            "HEIGHT 1\n"
            "VIEWPOINT 0 0 0 1 0 0 0\n"
            "POINTS 3\n"
            "DATA ascii\n"
            "4500000.123456789 0.1 -5 0 1 0 0.1 1\n"
            "-0 2 7 1 0 0 nan 4\n"
            "1e-300 3 32767 0 0 1 -inf 5\n");
  ASSERT_TRUE(SaveTable(table, dir.File("t.xyz")).ok());
  EXPECT_THAT(dir.Read("t.xyz"), StartsWith("# x y z nx ny nz k1 status\n4500000.123456789 0.1 -5 0 1 0 0.1 1\n"));
  ASSERT_TRUE(SaveTable(table, dir.File("t.ply"), {.ascii = true}).ok());
  EXPECT_THAT(dir.Read("t.ply"), HasSubstr("format ascii 1.0\n"));
  ASSERT_TRUE(SaveTable(table, dir.File("b.pcd")).ok());
  EXPECT_THAT(dir.Read("b.pcd"), HasSubstr("DATA binary\n"));
}

}  // namespace
}  // namespace curv
