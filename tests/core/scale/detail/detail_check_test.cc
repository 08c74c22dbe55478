#include "core/scale/detail/detail_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace curvd::testing {
namespace {

// Samples whose normals leave residual_at(rung) of a fit.
PilotTable SamplesWith(const std::function<double(size_t rung)>& residual_at) {
  PilotTable samples;
  for (int i = 0; i < 100; ++i) {
    PilotPoint& point = samples.emplace_back(std::array<float, 3>{});
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      point.normal_residual[rung] = static_cast<float>(residual_at(rung));
    }
  }
  return samples;
}

PilotTable IndependentNoise() {
  return SamplesWith([](size_t) { return 0.1; });
}

// A choice of the regression of degree 3 with that many neighbors, whose noise at each rung is noise_at(rung).
ScaleChoice RegressionAt(size_t chosen, const std::function<double(size_t rung)>& noise_at) {
  ScaleChoice choice;
  for (size_t rung = 0; rung < kRungCount; ++rung) {
    const double noise = noise_at(rung);
    choice.scores.push_back({{kRegressionMethod, rung}, noise, noise, noise, 0.0, rung == chosen ? 1.0 : 0.0});
  }
  choice.chosen = {{kRegressionMethod, chosen}};
  return choice;
}

// It halves where neighbors are twice as many.
double Halving(size_t rung) { return std::exp2(-0.5 * static_cast<double>(rung)); }

TEST(DetailCheckTest, HasAFewTimesTheLeastError) {
  constexpr size_t kChosen = 12;
  const auto check = FindDetailCheck(IndependentNoise(), RegressionAt(kChosen, Halving));
  ASSERT_TRUE(check.has_value());
  EXPECT_EQ(check->candidate.method, kRegressionMethod);
  EXPECT_LT(check->candidate.rung, kChosen);
  EXPECT_EQ(check->noise, Halving(check->candidate.rung));
  EXPECT_GT(check->noise, 4.0 * Halving(kChosen));
  EXPECT_LE(check->noise, 6.0 * Halving(kChosen));
}

TEST(DetailCheckTest, IsSmallerThanWhatIsChosen) {
  EXPECT_FALSE(FindDetailCheck(IndependentNoise(), RegressionAt(0, Halving)).has_value());
}

TEST(DetailCheckTest, NeedsNoiseThatFalls) {
  // What polynomials leave out of an exact surface grows with the neighborhood.
  EXPECT_FALSE(FindDetailCheck(IndependentNoise(), RegressionAt(12, [](size_t) { return 0.1; })).has_value());
  EXPECT_FALSE(FindDetailCheck(IndependentNoise(), RegressionAt(12, [](size_t) { return 0.0; })).has_value());
}

TEST(DetailCheckTest, NeedsErrorsOfNormalsThatAreIndependent) {
  const PilotTable shared = SamplesWith([](size_t rung) { return 0.01 * std::pow(1.1, static_cast<double>(rung)); });
  EXPECT_FALSE(FindDetailCheck(shared, RegressionAt(12, Halving)).has_value());
  const PilotTable unknown = SamplesWith([](size_t) { return PilotPoint::kNone; });
  EXPECT_FALSE(FindDetailCheck(unknown, RegressionAt(12, Halving)).has_value());
}

TEST(DetailCheckTest, IsNoneWherePositionsTellMoreThanNormals) {
  ScaleChoice choice = RegressionAt(12, Halving);
  const size_t rung = FindDetailCheck(IndependentNoise(), choice)->candidate.rung;
  choice.scores.push_back({{kQuarticMethod, rung}, 1.0, 1.0, 1.1 * Halving(rung), 0.0});
  EXPECT_TRUE(FindDetailCheck(IndependentNoise(), choice).has_value());
  choice.scores.back().noise = 0.9 * Halving(rung);
  EXPECT_FALSE(FindDetailCheck(IndependentNoise(), choice).has_value());
}

TEST(DetailCheckTest, NeedsTheRegressionOfNormals) {
  ScaleChoice choice = RegressionAt(12, Halving);
  for (ScaleScore& score : choice.scores) score.candidate.method = kHexagramMethod;
  EXPECT_FALSE(FindDetailCheck(IndependentNoise(), choice).has_value());
  EXPECT_FALSE(FindDetailCheck(IndependentNoise(), ScaleChoice()).has_value());
}

}  // namespace
}  // namespace curvd::testing
