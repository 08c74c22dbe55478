// Lines of a scanner: neighborhoods that show nothing of the curvature across them have none.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "core/estimators/strategies.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// The distance between lines on a cylinder of radius 1.
constexpr int kLines = 30;
constexpr double kBetween = 2.0 * std::numbers::pi / kLines;

// Lines along a cylinder of radius 1, `ratio` times as far apart as the points on them, which are moved by `noise`
// times the distance of lines; normals are exact.
TestPoints CylinderLines(int ratio, double noise) {
  TestPoints points;
  std::mt19937_64 engine(1);
  std::normal_distribution<double> moved(0.0, noise * kBetween);
  std::uniform_real_distribution<double> shift(0.0, kBetween / ratio);
  for (int line = 0; line < kLines; ++line) {
    const double angle = kBetween * line, x = std::cos(angle), y = std::sin(angle), first = shift(engine);
    for (int i = 0; i < 8 * ratio; ++i) {
      points.Add(x + moved(engine), y + moved(engine), first + kBetween / ratio * i + moved(engine), x, y, 0.0);
    }
  }
  return points;
}

EstimatorOptions Options(const Strategy& strategy, uint32_t count) {
  EstimatorOptions options;
  options.estimator = strategy.name;
  options.neighborhood = NeighborCount{count};
  return options;
}

struct Verdicts {
  size_t ok = 0;
  size_t wrong = 0;  // of the former: H is off by more than half of 0.5
};

Verdicts Judge(const TestPoints& points, const EstimatorOptions& options, double mean) {
  Verdicts verdicts;
  const EstimationResult result = MustEstimate(points.ToCloud(), options);
  for (size_t i = 0; i < points.size(); ++i) {
    const PointCurvature& point = result.field.points[i];
    if (point.status != PointStatus::kOk) continue;
    ++verdicts.ok;
    verdicts.wrong += std::abs(point.mean - mean) > 0.25 ? 1 : 0;
  }
  return verdicts;
}

TEST(LinesTest, OneLineHasNoCurvature) {
  for (const double noise : {0.001, 0.003}) {
    const TestPoints lines = CylinderLines(40, noise);
    for (const Strategy* strategy : Strategies()) {
      for (const uint32_t count : {20u, 30u}) {
        const Verdicts verdicts = Judge(lines, Options(*strategy, count), 0.5);
        EXPECT_LE(verdicts.wrong, lines.size() / 25) << strategy->name << " " << count << " " << noise;
      }
    }
  }
}

TEST(LinesTest, EnoughLinesHaveOne) {
  const TestPoints lines = CylinderLines(20, 0.003);
  for (const Strategy* strategy : Strategies()) {
    // These need denser lines: neighbors near the rim weigh next to nothing, and umbrellas have 30 points.
    if (strategy->name == "aso" || strategy->name == "delaunay") continue;
    const Verdicts verdicts = Judge(lines, Options(*strategy, 300), 0.5);
    EXPECT_EQ(verdicts.ok, lines.size()) << strategy->name;
    EXPECT_LE(verdicts.wrong, lines.size() / 100) << strategy->name;
  }
}

TEST(LinesTest, ThreeLinesFixNoPolynomialOfDegreeThreeOrMore) {
  const TestPoints lines = CylinderLines(20, 0.01);
  EstimatorOptions options = Options(*FindStrategy("jet"), 50);
  options.jet_degree = 4;
  EXPECT_LE(Judge(lines, options, 0.5).wrong, lines.size() / 25);
  // The regression of normals takes a lower degree.
  const Verdicts regression = Judge(lines, Options(*FindStrategy("normal-regression"), 50), 0.5);
  EXPECT_GE(regression.ok, lines.size() * 9 / 10);
  EXPECT_LE(regression.wrong, lines.size() / 25);
}

TEST(LinesTest, NoisyCloudsKeepTheirCurvature) {
  for (const double noise : {0.0, 0.01}) {
    const TestPoints waves = Waves(3000, noise, 5);
    for (const Strategy* strategy : Strategies()) {
      for (const uint32_t count : {20u, 50u}) {
        const EstimationResult result = MustEstimate(waves.ToCloud(), Options(*strategy, count));
        const auto& counts = result.field.status_counts;
        EXPECT_LE(counts[static_cast<size_t>(PointStatus::kDegenerateArea)] +
                      counts[static_cast<size_t>(PointStatus::kSingularFit)],
                  waves.size() / 100)
            << strategy->name << " " << count << " " << noise;
      }
    }
  }
}

}  // namespace
}  // namespace curvd::testing
