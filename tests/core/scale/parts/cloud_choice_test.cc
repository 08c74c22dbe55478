#include "core/scale/parts/cloud_choice.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace curvd::testing {
namespace {

constexpr ScaleCandidate kRegressionOf16{kRegressionMethod, 0}, kRegressionOf23{kRegressionMethod, 1},
    kRegressionOf32{kRegressionMethod, 2}, kJetOf16{kQuarticMethod, 0}, kJetOf45{kSexticMethod, 3},
    kQuadraticOf16{kQuadraticRegressionMethod, 0};

// Others err by 1.
PartChoice Part(std::vector<ScaleCandidate> chosen, bool positions_are_exact, double error_of_regressions = 1.0) {
  PartChoice part;
  for (const ScaleCandidate& candidate : chosen) {
    const double error = candidate.method == kRegressionMethod ? error_of_regressions : 1.0;
    part.choice.scores.push_back(ScaleScore{candidate, error, error, 0.0, 0.0, 0.25});
  }
  part.choice.chosen = std::move(chosen);
  part.positions_are_exact = positions_are_exact;
  return part;
}

TEST(CloudChoiceTest, CubicRegressionsOfFewNeighborsMayBeSteady) {
  const CloudChoice choice({Part({kJetOf45, kRegressionOf23, kRegressionOf16, kQuadraticOf16}, true)});
  EXPECT_FALSE(choice.MayBeSteady(0));
  EXPECT_TRUE(choice.MayBeSteady(1));
  EXPECT_TRUE(choice.MayBeSteady(2));
  EXPECT_FALSE(choice.MayBeSteady(3));
}

TEST(CloudChoiceTest, NoneMayBeSteadyWhereOthersLookMuchLessFar) {
  EXPECT_TRUE(CloudChoice({Part({kRegressionOf23, kJetOf16}, true)}).MayBeSteady(0));
  EXPECT_FALSE(CloudChoice({Part({kRegressionOf32, kJetOf16}, true)}).MayBeSteady(0));
}

TEST(CloudChoiceTest, NoneMayBeSteadyWherePositionsAreNoisy) {
  const CloudChoice choice({Part({kRegressionOf16}, false), Part({kJetOf45, kRegressionOf16}, true)});
  EXPECT_FALSE(choice.MayBeSteady(0));
  EXPECT_TRUE(choice.MayBeSteady(2)) << "a place among those of both parts";
}

TEST(CloudChoiceTest, NoneMayBeSteadyThatErrsByFarMoreThanOthers) {
  EXPECT_TRUE(CloudChoice({Part({kRegressionOf16, kJetOf45}, true, 4.0)}).MayBeSteady(0));
  EXPECT_FALSE(CloudChoice({Part({kRegressionOf16, kJetOf45}, true, 6.0)}).MayBeSteady(0));
}

}  // namespace
}  // namespace curvd::testing
