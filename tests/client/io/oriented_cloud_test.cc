#include "client/io/oriented_cloud.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

template <typename Scalar>
PointTable Table() {
  PointTable table;
  Scalar value = 0;
  for (const char* name : {"ny", "x", "z", "y", "nx", "nz", "extra"}) {
    table.Set({name, std::vector<Scalar>{value, static_cast<Scalar>(value + 10)}});
    ++value;
  }
  return table;
}

TEST(OrientedCloudTest, PacksFloats) {
  const absl::StatusOr<OrientedCloud> cloud = ExtractCloud(Table<float>());
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  const auto& packed = std::get<PackedCloud<float>>(*cloud);
  EXPECT_THAT(packed.positions, ElementsAre(1, 3, 2, 11, 13, 12));
  EXPECT_THAT(packed.normals, ElementsAre(4, 0, 5, 14, 10, 15));
}

TEST(OrientedCloudTest, KeepsDoubles) {
  PointTable table = Table<float>();
  table.Set({"y", std::vector<double>{4500000.0625, 0.0}});
  const absl::StatusOr<OrientedCloud> cloud = ExtractCloud(table);
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(std::get<PackedCloud<double>>(*cloud).positions[1], 4500000.0625);
}

TEST(OrientedCloudTest, KeepsLongIntegersExact) {
  PointTable table = Table<int16_t>();
  EXPECT_TRUE(std::holds_alternative<PackedCloud<float>>(*ExtractCloud(table)));
  table.Set({"x", std::vector<int32_t>{2147483647, 0}});
  EXPECT_EQ(std::get<PackedCloud<double>>(*ExtractCloud(table)).positions[0], 2147483647.0);
}

TEST(OrientedCloudTest, SaysWhatIsMissingAndWhatToDo) {
  PointTable table;
  for (const char* name : {"x", "y", "z", "intensity"}) table.Set({name, std::vector<float>{1}});
  EXPECT_THAT(ExtractCloud(table).status().message(),
              AllOf(HasSubstr("no normals"), HasSubstr("x y z intensity"), HasSubstr("--normals=estimate"),
                    HasSubstr("curv normals")));
  PointTable flat;
  flat.Set({"x", std::vector<float>{1}});
  EXPECT_THAT(ExtractCloud(flat).status().message(), HasSubstr("x, y and z are needed"));
}

TEST(OrientedCloudTest, TakesPositionsAloneWhereNormalsAreNotNeeded) {
  PointTable table;
  for (const char* name : {"x", "y", "z"}) table.Set({name, std::vector<float>{1, 2}});
  const absl::StatusOr<OrientedCloud> cloud = ExtractCloud(table, {.normals = false});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  const auto& packed = std::get<PackedCloud<float>>(*cloud);
  EXPECT_THAT(packed.positions, ElementsAre(1, 1, 1, 2, 2, 2));
  EXPECT_TRUE(packed.normals.empty() && packed.viewpoints.empty());
}

TEST(OrientedCloudTest, FindsWhereEachPointWasSeenFrom) {
  for (const std::string prefix : {"vp_", "viewpoint_", "sensor_", "scanner_"}) {
    PointTable table = Table<float>();
    EXPECT_FALSE(FindViewpoints(table).has_value());
    float value = 100;
    for (const char* axis : {"x", "y", "z"}) table.Set({prefix + axis, std::vector<double>{++value, value + 10}});
    EXPECT_EQ((*FindViewpoints(table))[2], prefix + "z");
    const absl::StatusOr<OrientedCloud> cloud = ExtractCloud(table, {.normals = false, .viewpoints = true});
    ASSERT_TRUE(cloud.ok()) << cloud.status();
    EXPECT_THAT(std::get<PackedCloud<float>>(*cloud).viewpoints, ElementsAre(101, 102, 103, 111, 112, 113));
  }
  EXPECT_THAT(ExtractCloud(Table<float>(), {.viewpoints = true}).status().message(), HasSubstr("vp_x, vp_y and vp_z"));
}

TEST(OrientedCloudTest, FindsADirectionForEachPoint) {
  for (const char* separator : {"", "_"}) {
    PointTable table;
    for (const char* axis : {"x", "y", "z"}) table.Set({axis, std::vector<float>{1.0f, 2.0f}});
    for (const char* axis : {"x", "y", "z"}) {
      table.Set({std::string("fiber") + separator + axis, std::vector<float>{3.0f, 4.0f}});
    }
    const auto cloud = ExtractCloud(table, {.normals = false, .directions = "fiber"});
    ASSERT_TRUE(cloud.ok()) << cloud.status();
    EXPECT_EQ(std::get<PackedCloud<float>>(*cloud).directions, (std::vector<float>{3, 3, 3, 4, 4, 4}));
    EXPECT_FALSE(ExtractCloud(table, {.normals = false, .directions = "wire"}).ok());
  }
}

TEST(OrientedCloudTest, NamesAFewColumnsAsATerminalMayShowThem) {
  PointTable table;
  table.Set({"\x1b[2J", std::vector<float>{1}});
  for (int i = 0; i < 40; ++i) table.Set({std::string(1, 'c') + std::to_string(i), std::vector<float>{1}});
  EXPECT_THAT(ExtractCloud(table).status().message(),
              AllOf(HasSubstr("columns: ?[2J c0"), HasSubstr("c28 and 11 more")));
}

}  // namespace
}  // namespace curv
