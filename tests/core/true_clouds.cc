#include "tests/core/true_clouds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <span>

namespace curvd::testing {

void TruePoints::Add(const std::array<double, 3>& position, const std::array<double, 3>& normal, double k1, double k2) {
  points.Add(position[0], position[1], position[2], normal[0], normal[1], normal[2]);
  mean.push_back(0.5 * (k1 + k2));
  gaussian.push_back(k1 * k2);
}

MeanErrors ErrorsOf(const TruePoints& truth, std::span<const PointCurvature> found) {
  MeanErrors errors;
  double count = 0.0;
  for (size_t i = 0; i < found.size(); ++i) {
    if (found[i].status != PointStatus::kOk) continue;
    errors.mean += std::abs(found[i].mean - truth.mean[i]);
    errors.gaussian += std::abs(found[i].gaussian - truth.gaussian[i]);
    count += 1.0;
  }
  return {errors.mean / count, errors.gaussian / count};
}

TruePoints TrueTorus(size_t points, uint64_t seed) {
  constexpr double kLarge = 3.0, kSmall = 1.0;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> angle(0.0, 2.0 * std::numbers::pi), share(0.0, 1.0);
  TruePoints torus;
  while (torus.mean.size() < points) {
    const double u = angle(random), v = angle(random), away = kLarge + kSmall * std::cos(v);
    if (share(random) * (kLarge + kSmall) > away) continue;
    const std::array<double, 3> n = {std::cos(v) * std::cos(u), std::cos(v) * std::sin(u), std::sin(v)};
    torus.Add({away * std::cos(u), away * std::sin(u), kSmall * n[2]}, n, 1.0 / kSmall, std::cos(v) / away);
  }
  return torus;
}

namespace {

// The height field z = sum of height sin(x x + y y + phase), at random places of a square.
struct Wave {
  double x, y, height, phase;
};

TruePoints SumOfWaves(const std::vector<Wave>& waves, double side, size_t points, std::mt19937_64& random) {
  std::uniform_real_distribution<double> place(0.0, side);
  TruePoints field;
  for (size_t i = 0; i < points; ++i) {
    const double x = place(random), y = place(random);
    double z = 0.0, p = 0.0, q = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
    for (const Wave& wave : waves) {
      const double at = wave.x * x + wave.y * y + wave.phase, slope = wave.height * std::cos(at);
      const double value = wave.height * std::sin(at);
      z += value, p += wave.x * slope, q += wave.y * slope;
      xx -= wave.x * wave.x * value, xy -= wave.x * wave.y * value, yy -= wave.y * wave.y * value;
    }
    // Bumps have positive curvature, as spheres whose normals point outward.
    const double w = std::sqrt(1.0 + p * p + q * q);
    const double mean = -((1.0 + q * q) * xx - 2.0 * p * q * xy + (1.0 + p * p) * yy) / (2.0 * w * w * w);
    const double gaussian = (xx * yy - xy * xy) / (w * w * w * w);
    const double half = std::sqrt(std::max(mean * mean - gaussian, 0.0));
    field.Add({x, y, z}, {-p / w, -q / w, 1.0 / w}, mean - half, mean + half);
  }
  return field;
}

}  // namespace

TruePoints RoughTerrain(size_t points, uint64_t seed) {
  constexpr double kSide = 10.0;
  constexpr int kMostWaves = 12, kWaves = 60;
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<int> number(-kMostWaves, kMostWaves);
  std::uniform_real_distribution<double> phase(0.0, 2.0 * std::numbers::pi);
  std::normal_distribution<double> height(0.0, 0.25);
  std::vector<Wave> waves;
  while (waves.size() < kWaves) {
    const int x = number(random), y = number(random);
    if (x == 0 && y == 0) continue;
    constexpr double kUnit = 2.0 * std::numbers::pi / kSide;
    waves.push_back({kUnit * x, kUnit * y, height(random) * std::pow(std::hypot(x, y), -1.2), phase(random)});
  }
  return SumOfWaves(waves, kSide, points, random);
}

TruePoints TexturedPlane(size_t points, double wavelength, double slope, uint64_t seed) {
  constexpr int kWaves = 12;
  const double side = std::sqrt(static_cast<double>(points)), number = 2.0 * std::numbers::pi / wavelength;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> angle(0.0, 2.0 * std::numbers::pi);
  std::vector<Wave> waves;
  for (int i = 0; i < kWaves; ++i) {
    const double direction = angle(random), height = slope / number * std::sqrt(2.0 / kWaves);
    waves.push_back({number * std::cos(direction), number * std::sin(direction), height, angle(random)});
  }
  return SumOfWaves(waves, side, points, random);
}

TruePoints ScannedCatenoid(size_t points, double gap, uint64_t seed) {
  constexpr double kHeight = 2.0;
  // Lines are longer, and farther from each other, the farther from the waist they are.
  const double ratio = 2.0 * kHeight / (gap * 2.0 * std::numbers::pi);
  const auto lines = static_cast<size_t>(std::sqrt(static_cast<double>(points) * ratio));
  const size_t on_line = points / lines;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> shift(0.0, 0.1);
  TruePoints catenoid;
  for (size_t line = 0; line < lines; ++line) {
    for (size_t i = 0; i < on_line; ++i) {
      const double v = kHeight * (2.0 * (static_cast<double>(line) + 0.5) / static_cast<double>(lines) - 1.0);
      const double u = 2.0 * std::numbers::pi * (static_cast<double>(i) + shift(random)) / static_cast<double>(on_line);
      const double away = std::cosh(v), k = 1.0 / (away * away);
      catenoid.Add({away * std::cos(u), away * std::sin(u), v}, {std::cos(u) / away, std::sin(u) / away, -std::tanh(v)},
                   -k, k);
    }
  }
  return catenoid;
}

}  // namespace curvd::testing
