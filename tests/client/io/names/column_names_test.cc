#include "client/io/names/column_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/io/table_file.h"
#include "client/io/writers.h"
#include "tests/client/io/samples.h"
#include "tests/client/temp_dir.h"

namespace curv {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

PointTable TableOfNames(const std::vector<std::string>& names) {
  PointTable table;
  for (size_t i = 0; i < names.size(); ++i) table.Set({names[i], std::vector<float>{static_cast<float>(i)}});
  return table;
}

TEST(ColumnNamesTest, KnowsTheSpellingsOfPositionsAndNormals) {
  EXPECT_EQ(TableName("X"), "x");
  for (const char* spelling : {"ny", "Ny", "NY", "normal_y", "Normal_Y", "NormalY", "normaly", "n_y"}) {
    EXPECT_EQ(TableName(spelling), "ny") << spelling;
  }
  for (const char* other : {"", "w", "Xx", "normal_w", "n", "Intensity", "d1x", "_x"})
    EXPECT_EQ(TableName(other), other);
}

TEST(ColumnNamesTest, RefusesTwoOfOneName) {
  const auto message = [](const std::vector<std::string>& names) {
    return std::string(TableNames(names, "fields").status().message());
  };
  EXPECT_THAT(message({"x", "i", "i"}), HasSubstr("two fields have the name \"i\""));
  EXPECT_THAT(message({"nx", "normal_x"}), HasSubstr("two fields have the name \"nx\": \"nx\" and \"normal_x\""));
  EXPECT_THAT(*TableNames({"X", "I", "i", "NormalZ"}, "fields"), ElementsAre("x", "I", "i", "nz"));
}

TEST(ColumnNamesTest, HeadersHaveEachNameOnce) {
  EXPECT_THAT(HeaderNames(TableOfNames({"a b", "a_b", "a,b", "c", ""}), HeaderName),
              ElementsAre("a_b_2", "a_b", "a_b_3", "c", "column"));
  EXPECT_THAT(HeaderNames(TableOfNames({"normal_x", "nx", "X", "x"}), HeaderName),
              ElementsAre("normal_x_2", "nx", "X_2", "x"));
}

TEST(ColumnNamesTest, FilesWithNamesThatWouldCollideAreReadAgain) {
  const TempDir dir;
  const PointTable table = TableOfNames({"k 1", "x", "y", "z", "k_1", "normal_x", "nx", "ny", "nz", "k;1"});
  for (const char* file : {"t.ply", "t.pcd", "t.csv", "t.xyz", "t.las"}) {
    ASSERT_TRUE(SaveTable(table, dir.File(file)).ok());
    const absl::StatusOr<PointTable> read = LoadTable(dir.File(file));
    ASSERT_TRUE(read.ok()) << file << ": " << read.status();
    EXPECT_THAT(Values(*read, "x"), ElementsAre(1)) << file;
    EXPECT_THAT(Values(*read, "nx"), ElementsAre(6)) << file;
    EXPECT_THAT(Values(*read, "normal_x_2"), ElementsAre(5)) << file;
    EXPECT_NE(read->Find("k_1"), nullptr) << file;
    EXPECT_NE(read->Find("k_1_2"), nullptr) << file;
    EXPECT_GE(read->columns().size(), table.columns().size()) << file;
  }
}

TEST(ColumnNamesTest, EveryFormatTakesEverySpelling) {
  const TempDir dir;
  for (const char* spelling : {"N", "normal_", "Normal", "n_"}) {
    const PointTable table = TableOfNames(
        {"X", "Y", "Z", std::string(spelling) + "x", std::string(spelling) + "Y", std::string(spelling) + "z"});
    for (const char* file : {"t.ply", "t.pcd", "t.csv", "t.xyz", "t.npy", "t.npz"}) {
      ASSERT_TRUE(SaveTable(table, dir.File(file)).ok());
      const absl::StatusOr<PointTable> read = LoadTable(dir.File(file));
      ASSERT_TRUE(read.ok()) << file << ": " << read.status();
      EXPECT_THAT(Values(*read, "y"), ElementsAre(1)) << file;
      EXPECT_THAT(Values(*read, "nz"), ElementsAre(5)) << file << " " << spelling;
    }
  }
}

}  // namespace
}  // namespace curv
