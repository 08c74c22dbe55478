// Surfaces on which the automatic choice once erred by much more than it had to.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string_view>

#include "tests/core/scale/automatic_requests.h"
#include "tests/core/seam_clouds.h"
#include "tests/core/true_clouds.h"

namespace curvd::testing {
namespace {

MeanErrors AutomaticErrors(const TruePoints& truth) {
  return ErrorsOf(truth, MustEstimate(truth.points.ToCloud(), Automatic()).field.points.span());
}

// Of fixed estimators and scales, each error for itself.
MeanErrors LeastErrors(const TruePoints& truth) {
  MeanErrors least = {1e300, 1e300};
  for (const std::string_view estimator : {"avg-hexagram", "normal-regression", "aso"}) {
    for (const uint32_t count : {16u, 32u, 64u, 128u, 256u, 512u, 1024u}) {
      const EstimatorOptions options{.estimator = estimator, .neighborhood = NeighborCount{count}};
      const EstimationResult result = MustEstimate(truth.points.ToCloud(), options);
      const size_t ok = result.field.status_counts[static_cast<size_t>(PointStatus::kOk)];
      if (20 * ok < 19 * truth.mean.size()) continue;
      const MeanErrors errors = ErrorsOf(truth, result.field.points.span());
      least = {std::min(least.mean, errors.mean), std::min(least.gaussian, errors.gaussian)};
    }
  }
  return least;
}

// Neighborhoods of a thousand points agree that such a terrain is flat: its Gaussian curvature is a product of two.
TEST(AutomaticSurfacesTest, RoughTerrainIsNotTakenForFlat) {
  const TruePoints terrain = RoughTerrain(6000, 1);
  const MeanErrors found = AutomaticErrors(terrain), least = LeastErrors(terrain);
  EXPECT_LT(found.mean, 1.15 * least.mean);
  EXPECT_LT(found.gaussian, 1.3 * least.gaussian);
}

// Neighborhoods of two or three lines agree on what is wrong across them.
TEST(AutomaticSurfacesTest, LinesOfAScannerAreCrossed) {
  for (const double gap : {3.0, 5.0, 10.0}) {
    const TruePoints catenoid = ScannedCatenoid(8000, gap, 2);
    const MeanErrors found = AutomaticErrors(catenoid), least = LeastErrors(catenoid);
    EXPECT_LT(found.mean, 4.5 * least.mean) << gap;
    EXPECT_LT(found.gaussian, 4.0 * least.gaussian) << gap;
  }
}

// Normals are exact and positions noisy, so that points on a line of their own seem to lie anywhere.
TEST(AutomaticSurfacesTest, NoiseDoesNotHideLines) {
  struct Scan {
    double gap, noise;  // 0.3 times as far as points of a line are apart at the waist
  };
  for (const auto [gap, noise] : {Scan{8.0, 0.0047}, Scan{20.0, 0.003}}) {
    TruePoints catenoid = ScannedCatenoid(12'000, gap, 2);
    AddNoise(noise, 0.0, 3, catenoid.points);
    const MeanErrors found = AutomaticErrors(catenoid), least = LeastErrors(catenoid);
    EXPECT_LT(found.mean, 1.5 * least.mean) << gap;
    EXPECT_LT(found.gaussian, 1.8 * least.gaussian) << gap;
  }
}

// The smooth step z = 0.3 tanh(8 w) with w = x + 0.3 sin 2y over [-1, 1]^2, on lines along x, the next of which is
// `gap` times as far as the next point of a line.
TruePoints ScannedStep(size_t count, double gap) {
  constexpr double kHeight = 0.3, kSteepness = 8.0;
  const double step = 2.0 / std::sqrt(static_cast<double>(count) * gap);
  std::mt19937_64 random(7);
  std::normal_distribution<double> shake(0.0, 0.1 * step);
  TruePoints points;
  for (double row = -1.0; row < 1.0; row += gap * step) {
    for (double column = -1.0; column < 1.0; column += step) {
      const double x = column + shake(random), y = row + shake(random);
      const double wy = 0.6 * std::cos(2.0 * y), wyy = -1.2 * std::sin(2.0 * y);
      const double t = std::tanh(kSteepness * (x + 0.3 * std::sin(2.0 * y)));
      const double first = kHeight * kSteepness * (1.0 - t * t), second = -2.0 * kSteepness * t * first;
      const double zx = first, zy = first * wy, zxx = second, zxy = second * wy, zyy = second * wy * wy + first * wyy;
      const double length = std::sqrt(1.0 + zx * zx + zy * zy);
      const double mean =
          -((1.0 + zy * zy) * zxx - 2.0 * zx * zy * zxy + (1.0 + zx * zx) * zyy) / (2.0 * length * length * length);
      const double gaussian = (zxx * zyy - zxy * zxy) / (length * length * length * length);
      const double half = std::sqrt(std::max(mean * mean - gaussian, 0.0));
      points.Add({x, y, kHeight * t}, {-zx / length, -zy / length, 1.0 / length}, mean - half, mean + half);
    }
  }
  return points;
}

// Neighborhoods of a few lines agree with larger ones as well as these among each other, and are nearer to the truth.
TEST(AutomaticSurfacesTest, FewLinesWillDoWhereLargerNeighborhoodsAgree) {
  for (const double gap : {3.0, 5.0}) {
    const TruePoints step = ScannedStep(3000, gap);
    const MeanErrors found = AutomaticErrors(step), least = LeastErrors(step);
    EXPECT_LT(found.mean, 1.3 * least.mean) << gap;
    EXPECT_LT(found.gaussian, 1.8 * least.gaussian) << gap;
  }
}

// Halves of the smallest neighborhoods have lost such texture, and all larger ones agree that there is none.
TEST(AutomaticSurfacesTest, TextureOfFewSpacingsIsKept) {
  struct Texture {
    double wavelength, slope, noise, noise_of_normals;
  };
  for (const auto& [wavelength, slope, noise, noise_of_normals] :
       {Texture{5.0, 0.1, 0.0, 0.1}, Texture{6.0, 0.1, 0.1, 0.1}, Texture{8.0, 0.1, 0.1, 0.1}}) {
    TruePoints texture = TexturedPlane(9000, wavelength, slope, 3);
    AddNoise(noise, noise_of_normals, 4, texture.points);
    EXPECT_LT(AutomaticErrors(texture).mean, 1.35 * LeastErrors(texture).mean) << wavelength;
  }
}

TEST(AutomaticSurfacesTest, ANoisyTorusIsBetterThanByAnyFixedEstimate) {
  for (const double of_normals : {0.05, 0.15}) {
    TruePoints torus = TrueTorus(16'000, 3);
    AddNoise(0.02, of_normals, 4, torus.points);
    const MeanErrors found = AutomaticErrors(torus), least = LeastErrors(torus);
    EXPECT_LT(found.mean, 0.9 * least.mean) << of_normals;
    EXPECT_LT(found.gaussian, 1.1 * least.gaussian) << of_normals;
  }
}

}  // namespace
}  // namespace curvd::testing
