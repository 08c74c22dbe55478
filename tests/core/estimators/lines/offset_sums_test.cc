#include "core/estimators/lines/offset_sums.h"

#include <gtest/gtest.h>

#include <cmath>

namespace curvd {
namespace {

TEST(OffsetSumsTest, AddsTheNearestWholeQuanta) {
  const double quantum = 0x1p-35;
  // Halves go to even quanta.
  for (const double quanta : {0.0, 0.4, 0.5, 0.6, 1.5, 2.5, 1e6 + 0.5, 0x1p35 - 0.25, 0x1p35, 0x1p37 + 3.0}) {
    for (const double sign : {-1.0, 1.0}) {
      OffsetSums<2> sums;
      sums.Add(0, sign * quanta * quantum);
      sums.Add(1, 0.25);
      sums.Add(1, sign * quanta * quantum);
      const double expected = std::nearbyint(sign * quanta) * quantum;
      EXPECT_EQ(sums[0], expected) << sign * quanta;
      EXPECT_EQ(sums[1], 0.25 + expected) << sign * quanta;
    }
  }
}

}  // namespace
}  // namespace curvd
