#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string_view>

#include "client/curvature_client.h"

namespace curv {
namespace {

using ::testing::ElementsAre;

TEST(EstimatorNamesTest, AreThoseOfTheContractInItsOrder) {
  EXPECT_THAT(EstimatorNames(), ElementsAre("avg-hexagram", "hexagram", "uniform", "independent", "delaunay", "jet",
                                            "aso", "normal-regression", "auto"));
}

TEST(EstimatorNamesTest, LeadBackToTheirEstimator) {
  for (const std::string_view name : EstimatorNames()) {
    const std::optional<Estimator> estimator = EstimatorOf(name);
    ASSERT_TRUE(estimator.has_value()) << name;
    EXPECT_EQ(EstimatorName(*estimator), name);
  }
}

TEST(EstimatorNamesTest, NobodyElseHasOne) {
  EXPECT_EQ(EstimatorOf(""), std::nullopt);
  EXPECT_EQ(EstimatorOf("unspecified"), std::nullopt);
  EXPECT_EQ(EstimatorOf("Jet"), std::nullopt);
  EXPECT_EQ(EstimatorName(static_cast<Estimator>(99)), "");
}

}  // namespace
}  // namespace curv
