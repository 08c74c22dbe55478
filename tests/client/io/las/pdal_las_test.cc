// Files that PDAL and LASzip wrote: LAS as it is, LAZ and COPC where lazperf is there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "client/io/formats.h"
#include "client/io/las/las_frame.h"
#include "client/io/las/laz_points.h"
#include "client/io/point_table.h"

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string Bytes(const std::string& name) {
  std::ifstream file(std::string(PDAL_FILES) + "/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

PointTable Read(const std::string& name) {
  absl::StatusOr<PointTable> table = ReadLas(Bytes(name));
  EXPECT_TRUE(table.ok()) << name << ": " << table.status();
  return table.ok() ? *std::move(table) : PointTable();
}

double At(const PointTable& table, const char* column, size_t point) {
  const Column* const found = table.Find(column);
  return found == nullptr ? std::nan("") : found->At(point);
}

// The values are those of the text that PDAL was given; see the README beside the files.
TEST(PdalLasTest, HasTheValuesThatPdalWasGiven) {
  for (const char* name : {"terrain_3.las", "terrain_7.las"}) {
    const PointTable table = Read(name);
    ASSERT_EQ(table.size(), 300u) << name;
    EXPECT_EQ(At(table, "x", 1), 500027.776);
    EXPECT_EQ(At(table, "y", 1), 5800016.261);
    EXPECT_EQ(At(table, "z", 1), 98.78);
    EXPECT_EQ(At(table, "intensity", 1), 1007);
    EXPECT_EQ(At(table, "gps_time", 1), 100000000.125);
    EXPECT_EQ(At(table, "red", 1), 257);
    EXPECT_EQ(At(table, "nz", 1), 0.9306222f);
    EXPECT_EQ(At(table, "point_source_id", 299), 42);
  }
}

TEST(PdalLasTest, CompressedPointsAreThoseOfThePlainFile) {
  const std::array<const char*, 2> pairs[] = {
      {"terrain_3.las", "terrain_3.laz"}, {"terrain_7.las", "terrain_7.laz"}, {"terrain_7.las", "terrain_7.copc.laz"}};
  for (const auto& [plain_name, compressed_name] : pairs) {
    if (!CanReadLaz()) {
      const absl::StatusOr<PointTable> refused = ReadLas(Bytes(compressed_name));
      EXPECT_THAT(std::string(refused.status().message()),
                  AllOf(HasSubstr("without lazperf"), HasSubstr("laszip -i in.laz -o out.las")));
      continue;
    }
    const PointTable plain = Read(plain_name), compressed = Read(compressed_name);
    ASSERT_EQ(compressed.columns().size(), plain.columns().size()) << compressed_name;
    for (const Column& column : plain.columns()) {
      const Column* const other = compressed.Find(column.name);
      ASSERT_NE(other, nullptr) << column.name;
      for (size_t i = 0; i < column.size(); ++i) ASSERT_EQ(other->At(i), column.At(i)) << column.name << " of " << i;
    }
    // A file that is made of it is not compressed, and must not say so.
    for (const LasRecord& record : compressed.las->records) {
      EXPECT_FALSE(record.Is("laszip encoded", 22204) || record.Is("copc", 1) || record.Is("copc", 1000));
    }
  }
}

TEST(PdalLasTest, TruncatedAndDamagedFilesEndInAnError) {
  const std::string good = Bytes("terrain_7.laz");
  for (size_t size = 0; size < good.size(); size += 97) {
    EXPECT_FALSE(ReadLas(std::string_view(good).substr(0, size)).ok()) << size;
  }
  std::string lying = good;
  lying.replace(247, 8, std::string("\xff\xff\xff\xff\x00\x00\x00\x00", 8));  // the number of point records
  lying.replace(107, 4, std::string(4, '\0'));
  EXPECT_FALSE(ReadLas(lying).ok());
  std::string chunks = good;
  uint32_t points_at;
  std::memcpy(&points_at, &good[96], sizeof(points_at));
  chunks.replace(points_at, 8, std::string("\xff\xff\xff\xff\x00\x00\x00\x40", 8));  // where the table of chunks is
  EXPECT_FALSE(ReadLas(chunks).ok());
}

}  // namespace
}  // namespace curv
