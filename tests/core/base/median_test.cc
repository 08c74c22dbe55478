#include "core/base/median.h"

#include <gtest/gtest.h>

#include <vector>

namespace curvd {
namespace {

TEST(MedianTest, IsTheMiddleValueOrTheLargerOfTwo) {
  EXPECT_EQ(Median({3.0}), 3.0);
  EXPECT_EQ(Median({4.0, 2.0}), 4.0);
  EXPECT_EQ(Median({9.0, 1.0, 5.0}), 5.0);
  EXPECT_EQ(Median({4.0, 1.0, 3.0, 2.0}), 3.0);
}

}  // namespace
}  // namespace curvd
