#include "core/scale/judging/growing_bias.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>

namespace curvd::testing {
namespace {

using Changes = std::array<std::optional<CommonChange>, kRungCount>;

// Changes of these lengths from `first` on, each known to a tenth of its square; before that, noise hides them.
template <typename Length>
Changes ChangesFrom(size_t first, size_t step, const Length& length_at) {
  Changes changes;
  for (size_t rung = 0; rung + step < kRungCount; ++rung) {
    const double square = length_at(rung) * length_at(rung);
    changes[rung] = rung < first ? CommonChange{1.0, 10.0, 10.0} : CommonChange{square, 0.1 * square, 2.0 * square};
  }
  return changes;
}

TEST(GrowingBiasTest, ABiasThatGrowsEvenlyIsFoundFromItsChanges) {
  for (const size_t step : {1, 2}) {
    for (const double growth : {2.0, 3.0}) {
      const auto bias_at = [&](size_t rung) {
        return 1e-3 * std::pow(growth, static_cast<double>(rung) / static_cast<double>(step));
      };
      const GrowingBias bias(ChangesFrom(5, step, [&](size_t rung) { return (growth - 1.0) * bias_at(rung); }), step);
      for (size_t rung = 2; rung < kRungCount; ++rung) {
        EXPECT_NEAR(bias.At(rung), bias_at(rung), 1e-9) << rung << ", " << step << ", " << growth;
      }
      EXPECT_NEAR(bias.PerChange(7), 1.0 / (growth - 1.0), 1e-9);
      EXPECT_NEAR(bias.PerChange(3), 1.0 / (growth - 1.0), 1e-9) << "where noise hides the change";
    }
  }
}

TEST(GrowingBiasTest, OfChangesThatDoNotGrowSomeWereBefore) {
  const GrowingBias bias(ChangesFrom(5, 1, [](size_t) { return 2.0; }), 1);
  EXPECT_DOUBLE_EQ(bias.At(5), 3.0);
  EXPECT_DOUBLE_EQ(bias.At(6), 5.0);
  EXPECT_DOUBLE_EQ(bias.At(8), 9.0);
  EXPECT_DOUBLE_EQ(bias.PerChange(8), 4.5);
  // Before, it falls as that of a smooth surface does.
  EXPECT_DOUBLE_EQ(bias.At(4), 1.5);
  EXPECT_DOUBLE_EQ(bias.At(3), 0.75);
}

TEST(GrowingBiasTest, WhereTheOneBeforeIsKnownToBeSmallHardlyAnyWere) {
  Changes changes = ChangesFrom(5, 1, [](size_t) { return 2.0; });
  changes[4] = CommonChange{0.05, 0.1, 0.1};  // at most 0.5 squared
  EXPECT_DOUBLE_EQ(GrowingBias(changes, 1).At(5), 2.0 / 3.0);
}

TEST(GrowingBiasTest, OneChangeThatCountsTellsNothing) {
  Changes changes = ChangesFrom(kRungCount, 1, [](size_t) { return 0.0; });
  changes[6] = CommonChange{1.0, 0.1, 2.0};
  const GrowingBias bias(changes, 1);
  for (size_t rung = 0; rung < kRungCount; ++rung) {
    EXPECT_EQ(bias.At(rung), 0.0);
    EXPECT_EQ(bias.PerChange(rung), 0.0);
  }
  EXPECT_EQ(GrowingBias(Changes{}, 2).At(kRungCount - 1), 0.0) << "no halves";
  EXPECT_EQ(GrowingBias().At(0), 0.0);
}

TEST(GrowingBiasTest, LaterChangesThatNoiseHidesAddNothing) {
  Changes changes = ChangesFrom(5, 1, [](size_t) { return 2.0; });
  changes[8] = CommonChange{-0.5, 0.4, 1.0};
  changes[9].reset();
  const GrowingBias bias(changes, 1);
  EXPECT_DOUBLE_EQ(bias.At(9), bias.At(8));
  EXPECT_DOUBLE_EQ(bias.At(10), bias.At(8));
  EXPECT_EQ(bias.PerChange(8), 0.0);
}

}  // namespace
}  // namespace curvd::testing
