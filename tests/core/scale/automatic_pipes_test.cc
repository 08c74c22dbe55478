// Pipes and small spheres, around which the linear regression of normals may look all the way.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "tests/core/scale/automatic_requests.h"
#include "tests/core/seam_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// Nothing counts that leaves more than a twentieth of the points without a result.
double MeanErrorOfNearlyAll(const EstimationResult& result, double truth) {
  const size_t ok = result.field.status_counts[static_cast<size_t>(PointStatus::kOk)];
  return 20 * ok > 19 * result.field.points.size() ? MeanError(result, truth) : 1e300;
}

double LeastErrorOfOthers(const TestPoints& points, double truth) {
  double least = 1e300;
  for (const std::string_view estimator : {"avg-hexagram", "normal-regression", "jet", "aso"}) {
    for (const uint32_t count : {32u, 64u, 128u, 256u, 512u}) {
      if (count > points.size()) break;
      const EstimatorOptions options{.estimator = estimator, .neighborhood = NeighborCount{count}};
      least = std::min(least, MeanErrorOfNearlyAll(MustEstimate(points.ToCloud(), options), truth));
    }
  }
  return least;
}

void ExpectBetterThanOthers(TestPoints points, double truth, double times) {
  const EstimationResult exact = MustEstimate(points.ToCloud(), Automatic());
  EXPECT_LT(MeanErrorOfNearlyAll(exact, truth), 1e-5);
  AddNoise(0.01, 0.05, 7, points);
  const EstimationResult noisy = MustEstimate(points.ToCloud(), Automatic());
  EXPECT_LT(MeanErrorOfNearlyAll(noisy, truth), times * LeastErrorOfOthers(points, truth));
}

TEST(AutomaticPipesTest, PipesOfADozenPointsAround) { ExpectBetterThanOthers(Pipe(1500, 1), 1.0, 0.3); }

TEST(AutomaticPipesTest, PipesOfTwoDozenPointsAround) { ExpectBetterThanOthers(Pipe(6000, 2), 1.0, 0.3); }

TEST(AutomaticPipesTest, SmallSpheres) {
  ExpectBetterThanOthers(Sphere(300, 1.0), 1.0, 0.95);
  ExpectBetterThanOthers(Sphere(1500, 1.0), 1.0, 0.5);
}

TEST(AutomaticPipesTest, ABulgeOfAPipeIsKept) {
  // A bulge of revolution, which an estimate of a thousand neighbors would smooth away.
  constexpr size_t kPoints = 20'000;
  TestPoints pipe;
  std::vector<double> truth;
  const TestPoints even = Pipe(kPoints, 5);
  const double root = std::sqrt(0.5);
  for (size_t i = 0; i < kPoints; ++i) {
    const auto& p = even.positions[i];
    const double along = root * (p[1] + p[2]), angle = std::atan2(root * (p[1] - p[2]), p[0]);
    const double bulge = 0.05 * std::exp(-2.0 * along * along), radius = 0.5 + bulge, slope = -4.0 * along * bulge,
                 bend = (16.0 * along * along - 4.0) * bulge, w = std::sqrt(1.0 + slope * slope);
    const double x = std::cos(angle), y = std::sin(angle);
    pipe.Add(radius * x, root * (radius * y + along), root * (along - radius * y), x / w, root * (y - slope) / w,
             root * (-slope - y) / w);
    truth.push_back(0.5 * (1.0 / (radius * w) - bend / (w * w * w)));
  }
  AddNoise(0.002, 0.02, 7, pipe);
  const EstimationResult result = MustEstimate(pipe.ToCloud(), Automatic());
  double of_bulge = 0.0;
  size_t count = 0;
  for (size_t i = 0; i < kPoints; ++i) {
    const auto& p = pipe.positions[i];
    if (std::abs(root * (p[1] + p[2])) > 1.0) continue;
    of_bulge += std::abs(result.field.points[i].mean - truth[i]);
    ++count;
  }
  EXPECT_LT(of_bulge / static_cast<double>(count), 0.03) << "|H| differs from the pipe's by up to 0.17";
}

}  // namespace
}  // namespace curvd::testing
