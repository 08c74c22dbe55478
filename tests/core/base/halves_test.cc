#include "core/base/halves.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>

namespace curvd {
namespace {

TEST(HalvesTest, AreAboutAsLarge) {
  size_t even = 0;
  for (int32_t id = 0; id < 10'000; ++id) even += HalfOf(id) == Half::kEven ? 1 : 0;
  EXPECT_NEAR(static_cast<double>(even), 5'000.0, 200.0) << "4 standard deviations of 10,000 tossed coins";
}

}  // namespace
}  // namespace curvd
