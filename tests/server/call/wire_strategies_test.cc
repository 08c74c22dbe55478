#include "server/call/wire_strategies.h"

#include <gtest/gtest.h>

#include "core/estimators/strategies.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

TEST(WireStrategiesTest, EveryStrategyHasAValueThatLeadsBackToIt) {
  for (const Strategy* strategy : Strategies()) {
    const v1::Estimator estimator = WireEstimator(*strategy);
    EXPECT_NE(estimator, v1::ESTIMATOR_UNSPECIFIED) << strategy->name;
    EXPECT_EQ(StrategyOf(estimator), strategy) << strategy->name;
  }
}

TEST(WireStrategiesTest, EveryValueOfTheContractIsAStrategy) {
  const auto* values = v1::Estimator_descriptor();
  for (int i = 0; i < values->value_count(); ++i) {
    const auto estimator = static_cast<v1::Estimator>(values->value(i)->number());
    const bool is_none = estimator == v1::ESTIMATOR_UNSPECIFIED || estimator == v1::ESTIMATOR_AUTO;  // a choice of some
    EXPECT_EQ(StrategyOf(estimator) == nullptr, is_none) << values->value(i)->name();
  }
}

TEST(WireStrategiesTest, ValuesThatNobodyKnowsAreNoStrategy) {
  EXPECT_EQ(StrategyOf(static_cast<v1::Estimator>(99)), nullptr);
}

TEST(WireStrategiesTest, NamesOfTheContractMayBeLonger) {
  EXPECT_EQ(StrategyOf(v1::ESTIMATOR_JET_FITTING), FindStrategy("jet"));
  EXPECT_EQ(StrategyOf(v1::ESTIMATOR_ALGEBRAIC_SHAPE_OPERATOR), FindStrategy("aso"));
  EXPECT_EQ(StrategyOf(v1::ESTIMATOR_NORMAL_REGRESSION), FindStrategy("normal-regression"));
  EXPECT_EQ(StrategyOf(v1::ESTIMATOR_AVG_HEXAGRAM), FindStrategy("avg-hexagram"));
}

}  // namespace
}  // namespace curvd
