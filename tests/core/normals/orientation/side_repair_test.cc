#include "core/normals/orientation/side_repair.h"

#include <gtest/gtest.h>

#include <vector>

namespace curvd::testing {
namespace {

// A field of clusters, each of which adds `own` at its own samples and `others` at those of others.
FieldPiece Field(size_t clusters, size_t samples_each, float own, float others) {
  FieldPiece field;
  for (uint32_t c = 0; c < clusters; ++c) {
    field.clusters.push_back(c);
    for (size_t k = 0; k < samples_each; ++k)
      field.samples.push_back({static_cast<uint32_t>(field.samples.size()), 1.0f});
  }
  for (size_t c = 0; c < clusters; ++c) {
    for (size_t k = 0; k < field.samples.size(); ++k) field.values.push_back(k / samples_each == c ? own : others);
  }
  return field;
}

void DescendAll(SideRepair& repair) {
  for (size_t start = 0; start < SideRepair::kStarts; ++start) repair.Descend(start);
}

TEST(SideRepairTest, RightSidesFitAndStay) {
  const FieldPiece field = Field(8, 20, 0.3f, 0.03f);
  const SideRepair repair(field, std::vector<uint8_t>(8, 0), false);
  EXPECT_NEAR(repair.certificate(), 0.0, 1e-6);
  EXPECT_NEAR(repair.mean(), 0.51, 1e-5);
  EXPECT_FALSE(repair.IsWanted());
}

TEST(SideRepairTest, TurnsWhatIsWrong) {
  const FieldPiece field = Field(8, 20, 0.3f, 0.03f);
  SideRepair repair(field, {0, 1, 0, 1, 1, 0, 0, 0}, false);
  EXPECT_GT(repair.certificate(), 0.12);
  ASSERT_TRUE(repair.IsWanted());
  DescendAll(repair);
  EXPECT_TRUE(repair.IsPromising());
  ASSERT_TRUE(repair.Accept());
  EXPECT_EQ(repair.turned(), std::vector<uint8_t>(8, 0));
  EXPECT_NEAR(repair.certificate(), 0.0, 1e-6);
}

TEST(SideRepairTest, InwardSidesAreTheWorst) {
  const FieldPiece field = Field(4, 20, 0.3f, 0.03f);
  SideRepair repair(field, std::vector<uint8_t>(4, 1), false);
  EXPECT_EQ(repair.certificate(), 2.0);
  repair.Descend(0);
  EXPECT_TRUE(repair.Accept());
  EXPECT_EQ(repair.turned(), std::vector<uint8_t>(4, 0));
}

// A sheet has hardly a winding number, and what it has means nothing.
TEST(SideRepairTest, FieldsThatAreTooWeakChangeNothing) {
  const FieldPiece field = Field(8, 20, 0.1f, 0.0f);
  SideRepair repair(field, {0, 1, 0, 1, 1, 0, 0, 0}, false);
  DescendAll(repair);
  EXPECT_FALSE(repair.IsPromising());
  EXPECT_FALSE(repair.Accept());
  EXPECT_EQ(repair.turned(), (std::vector<uint8_t>{0, 1, 0, 1, 1, 0, 0, 0}));
}

// Sides that fit may be those of a bowl: the normals of a closed surface add up to nothing.
TEST(SideRepairTest, TakesNoSidesThatDoNotClose) {
  FieldPiece field = Field(8, 20, 0.3f, 0.03f);
  field.area = 8.0f;
  field.moments.assign(8, {0.0f, 0.0f, 1.0f});
  const std::vector<uint8_t> mixed = {0, 1, 0, 1, 1, 0, 0, 0};
  SideRepair open(field, mixed, true);
  DescendAll(open);
  EXPECT_FALSE(open.IsPromising());
  EXPECT_FALSE(open.Accept());
  EXPECT_EQ(open.turned(), mixed);
  for (size_t c = 0; c < 4; ++c) field.moments[c][2] = -1.0f;
  SideRepair closed(field, mixed, true);
  DescendAll(closed);
  ASSERT_TRUE(closed.Accept());
  EXPECT_EQ(closed.turned(), std::vector<uint8_t>(8, 0));
}

TEST(SideRepairTest, SamplesWithoutAreaCountForNothing) {
  FieldPiece field = Field(2, 10, 0.5f, 0.0f);
  for (FieldSample& sample : field.samples) sample.weight = 0.0f;
  SideRepair repair(field, {0, 0}, false);
  EXPECT_EQ(repair.certificate(), 2.0);
  DescendAll(repair);
  EXPECT_FALSE(repair.Accept());
}

}  // namespace
}  // namespace curvd::testing
