#include "client/neighbors/spatial_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace curv {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(SpatialOrderTest, GoesFromCellToCell) {
  // Two clusters, whose points come in turns; the curve goes through one of them after the other.
  std::vector<Vec3> positions;
  for (int i = 0; i < 100; ++i) positions.push_back({i % 2 == 0 ? 0.0 : 1.0, 1e-3 * i, 1e-4 * i});
  const std::vector<uint32_t> order = SpatialOrder(positions);
  ASSERT_EQ(order.size(), 100u);
  for (size_t i = 0; i < 100; ++i) EXPECT_EQ(order[i] % 2, i < 50 ? 0u : 1u);
}

TEST(SpatialOrderTest, OneCellKeepsItsOrder) {
  EXPECT_THAT(SpatialOrder(std::vector<Vec3>(4, {1, 2, 3})), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(SpatialOrder({}), IsEmpty());
}

TEST(SpatialOrderTest, SurvivesTheLargestNumbers) {
  constexpr double kLargest = std::numeric_limits<double>::max();
  EXPECT_THAT(SpatialOrder({{kLargest, 0, 0}, {-kLargest, 0, 0}}), ElementsAre(1, 0));
}

}  // namespace
}  // namespace curv
