#include "core/scale/parts/cloud_choice.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace curvd::testing {
namespace {

constexpr ScaleCandidate kRegressionOf16{kRegressionMethod, 0}, kRegressionOf23{kRegressionMethod, 1},
    kRegressionOf32{kRegressionMethod, 2}, kJetOf16{kQuarticMethod, 0}, kJetOf45{kSexticMethod, 3},
    kQuadraticOf16{kQuadraticRegressionMethod, 0};

PartChoice Part(std::vector<ScaleCandidate> chosen, bool positions_are_exact) {
  PartChoice part;
  part.choice.chosen = std::move(chosen);
  part.positions_are_exact = positions_are_exact;
  return part;
}

TEST(CloudChoiceTest, CubicRegressionsOfFewNeighborsMayBeSteady) {
  const CloudChoice choice({Part({kJetOf45, kRegressionOf23, kRegressionOf16, kQuadraticOf16}, true)});
  EXPECT_FALSE(choice.MayBeSteady(0, 0));
  EXPECT_TRUE(choice.MayBeSteady(0, 1));
  EXPECT_TRUE(choice.MayBeSteady(0, 2));
  EXPECT_FALSE(choice.MayBeSteady(0, 3));
}

TEST(CloudChoiceTest, NoneMayBeSteadyWhereOthersLookMuchLessFar) {
  EXPECT_TRUE(CloudChoice({Part({kRegressionOf23, kJetOf16}, true)}).MayBeSteady(0, 0));
  EXPECT_FALSE(CloudChoice({Part({kRegressionOf32, kJetOf16}, true)}).MayBeSteady(0, 0));
}

TEST(CloudChoiceTest, NoneMayBeSteadyWherePositionsAreNoisy) {
  const CloudChoice choice({Part({kRegressionOf16}, false), Part({kJetOf45, kRegressionOf16}, true)});
  EXPECT_FALSE(choice.MayBeSteady(0, 0));
  EXPECT_TRUE(choice.MayBeSteady(1, 2)) << "a place among those of both parts";
}

}  // namespace
}  // namespace curvd::testing
