#include "core/scale/pilot/pilot_fits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/core/instruction_sets.h"

namespace curvd::testing {
namespace {

// Random neighbors of a bent surface, of which jets of degree 6 are estimated too.
PilotSums RandomSums(size_t count, double radius, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> coordinate(-0.7 * radius, 0.7 * radius);
  PilotSums sums;
  for (size_t i = 0; i < count; ++i) {
    const double x = coordinate(random), y = coordinate(random), z = -0.2 * x * x + 0.1 * y * y + 0.3 * x * y * y;
    const double nx = 0.4 * x - 0.3 * y * y, ny = -0.2 * y - 0.6 * x * y, length = std::sqrt(1.0 + nx * nx + ny * ny);
    sums.Add({{x, y, z}, {nx / length, ny / length, 1.0 / length}});
  }
  return sums;
}

struct Neighborhood {
  PilotSums sums;
  double radius;
};

// The third has too few neighbors for anything, and the fifth has them on a line.
std::vector<Neighborhood> Neighborhoods() {
  std::vector<Neighborhood> all;
  for (const size_t count : {23, 45, 3, 91, 0, 181, 256}) {
    const double radius = 0.02 * std::sqrt(static_cast<double>(count + 1));
    all.push_back({RandomSums(count, radius, count), radius});
  }
  for (int i = 0; i < 60; ++i) all[4].sums.Add({{0.001 * i, 0.0, 0.0}, {0.0, 0.0, 1.0}});
  return all;
}

void Append(const std::optional<TangentShape>& shape, std::vector<double>& out) {
  out.push_back(shape.has_value() ? 1.0 : 0.0);
  if (shape.has_value()) out.insert(out.end(), {shape->mean, shape->difference, shape->twist});
}

void Append(const std::optional<PilotFits::Jet>& jet, std::vector<double>& out) {
  Append(jet.has_value() ? std::optional(jet->shape) : std::nullopt, out);
  if (jet.has_value()) out.push_back(jet->residual);
}

// Whatever was found, number by number.
std::vector<double> NumbersOf(const PilotFits& fits) {
  std::vector<double> numbers;
  Append(fits.quadratic_regression, numbers);
  Append(fits.linear_regression, numbers);
  for (const auto& jet : {fits.quartic, fits.quadric, fits.sextic}) Append(jet, numbers);
  if (const auto& regression = fits.regression) {
    Append(regression->shape, numbers);
    for (const TangentShape& slope : regression->slope) Append(slope, numbers);
    numbers.push_back(regression->residual);
  }
  return numbers;
}

std::vector<std::vector<double>> FitTogether(const std::vector<Neighborhood>& neighborhoods) {
  PilotFitter fitter;
  for (const auto& [sums, radius] : neighborhoods) fitter.Add(sums, radius);
  const size_t size = fitter.size();
  const auto fits = fitter.Fit();
  std::vector<std::vector<double>> numbers;
  for (size_t i = 0; i < size; ++i) numbers.push_back(NumbersOf(fits[i]));
  return numbers;
}

class PilotFitsTest : public InstructionSetTest {};

TEST_P(PilotFitsTest, NeighborhoodsThatAreFittedTogetherAreNotMixed) {
  const std::vector<Neighborhood> all = Neighborhoods();
  const auto together = FitTogether(all);
  for (size_t i = 0; i < all.size(); ++i) EXPECT_EQ(together[i], FitTogether({all[i]}).front()) << i;
}

TEST_P(PilotFitsTest, AreTheSameOnEveryInstructionSet) {
  const std::vector<Neighborhood> all = Neighborhoods();
  const auto here = FitTogether(all);
  hwy::SetSupportedTargetsForTest(0);
  EXPECT_EQ(here, FitTogether(all));
}

TEST_P(PilotFitsTest, AFitterThatHasFittedBeginsAnew) {
  const std::vector<Neighborhood> all = Neighborhoods();
  PilotFitter fitter;
  for (const auto& [sums, radius] : all) fitter.Add(sums, radius);
  fitter.Fit();
  EXPECT_EQ(fitter.size(), 0U);
  fitter.Add(all[0].sums, all[0].radius);
  EXPECT_EQ(NumbersOf(fitter.Fit().front()), FitTogether({all[0]}).front());
}

TEST_P(PilotFitsTest, FindsWhatEachNeighborhoodShows) {
  PilotFitter fitter;
  for (const auto& [sums, radius] : Neighborhoods()) fitter.Add(sums, radius);
  const auto fits = fitter.Fit();
  for (const size_t i : {3, 5, 6}) {
    // Graphs of degree 3, which has no part in the curvature at the point: k = 0.4 and -0.2.
    EXPECT_NEAR(fits[i].sextic->shape.mean, 0.1, 1e-8) << i;
    EXPECT_NEAR(fits[i].quartic->shape.difference, 0.3, 1e-9) << i;
    EXPECT_NEAR(fits[i].regression->shape.mean, 0.1, 1e-3) << i;
  }
  EXPECT_FALSE(fits[0].sextic.has_value()) << "23 neighbors are too few for 28 coefficients";
  EXPECT_TRUE(fits[0].regression.has_value());
  for (const size_t i : {2, 4}) {
    EXPECT_FALSE(fits[i].regression.has_value() || fits[i].quadratic_regression.has_value()) << i;
    EXPECT_FALSE(fits[i].linear_regression.has_value()) << i;
    EXPECT_FALSE(fits[i].quartic.has_value() || fits[i].quadric.has_value() || fits[i].sextic.has_value()) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, PilotFitsTest, InstructionSets(), InstructionSetName);

}  // namespace
}  // namespace curvd::testing
