#include "core/normals/trust/noise_probe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "tests/core/normals/trust/probed_clouds.h"

namespace curvd::testing {
namespace {

// Under sanitizers as well: fewer points tell less.
TestPoints NoisyTorus(double sigma) {
  TestPoints torus = Torus(8'000, 3);
  AddNoise(sigma, 9, torus);
  return torus;
}

struct NoiseFinding {
  std::optional<double> squared_error;
  size_t block_count = 0;
};

NoiseFinding ProbeNoise(const TestPoints& points, bool backwards = false) {
  const SpatialIndex index = BuildIndex(points.ToCloud());
  NoiseProbe probe(index, 10'000, 1);
  const std::atomic<bool> stopped = false;
  NoiseFinding found;
  while (probe.AddBlocks()) {
    found.block_count += probe.block_count();
    for (size_t i = 0; i < probe.block_count(); ++i) {
      EXPECT_TRUE(probe.RunBlock(backwards ? probe.block_count() - 1 - i : i, 0, stopped).ok());
    }
  }
  found.squared_error = probe.SquaredError();
  return found;
}

std::optional<double> ProbedError(const TestPoints& points, bool backwards = false) {
  return ProbeNoise(points, backwards).squared_error;
}

double SquaredError(const TestPoints& points, const TestPoints& exact) {
  double sum = 0.0;
  for (size_t i = 0; i < points.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double difference = points.normals[i][axis] - exact.normals[i][axis];
      sum += difference * difference;
    }
  }
  return sum / static_cast<double>(points.size());
}

// Normals with noise of their own, of that standard deviation along each axis.
TestPoints WithNoisyNormals(TestPoints points, float sigma) {
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0.0f, sigma);
  for (auto& normal : points.normals) {
    for (int axis = 0; axis < 3; ++axis) normal[axis] += noise(random);
  }
  return points;
}

// Each normal becomes the mean of those of the points within a radius.
TestPoints WithSmoothedNormals(TestPoints points, double radius) {
  const TestPoints before = points;
  std::vector<size_t> along_x(points.size());
  std::iota(along_x.begin(), along_x.end(), size_t{0});
  std::sort(along_x.begin(), along_x.end(),
            [&](size_t a, size_t b) { return before.positions[a][0] < before.positions[b][0]; });
  for (size_t at = 0; at < along_x.size(); ++at) {
    const size_t i = along_x[at];
    for (size_t next = at + 1; next < along_x.size(); ++next) {
      const size_t j = along_x[next];
      double squared = 0.0;
      for (int axis = 0; axis < 3; ++axis)
        squared += std::pow(before.positions[i][axis] - before.positions[j][axis], 2);
      if (before.positions[j][0] - before.positions[i][0] > radius) break;
      if (squared > radius * radius) continue;
      for (int axis = 0; axis < 3; ++axis) {
        points.normals[i][axis] += before.normals[j][axis];
        points.normals[j][axis] += before.normals[i][axis];
      }
    }
  }
  return points;
}

// The points of two scans, each with normals that were made of its own points, in turns.
TestPoints MergedScans(const TestPoints& points, uint32_t count) {
  TestPoints scans[2], merged;
  for (size_t i = 0; i < points.size(); ++i) {
    const auto& p = points.positions[i];
    const auto& n = points.normals[i];
    scans[i % 2].Add(p[0], p[1], p[2], n[0], n[1], n[2]);
  }
  for (TestPoints& scan : scans) scan = WithFittedNormals(std::move(scan), NormalMethod::kPca, count);
  Append(scans[1], scans[0]);
  return scans[0];
}

// Waves on a plane, with exact normals and noise across it. So long, in units of the distance of points on a grid, or
// of the mean distance of points at random.
TestPoints Waves(double length, double noise, bool on_grid, double grid_step_x = 1.0) {
  constexpr int kSide = 80;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(0.0, kSide);
  std::normal_distribution<double> across(0.0, noise);
  const double k = 2.0 * std::numbers::pi / length, height = 0.1 * length;
  TestPoints points;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double x = on_grid ? grid_step_x * (i % kSide) : place(random);
    const double y = on_grid ? static_cast<double>((i - i % kSide) / kSide) : place(random);
    const double sx = height * k * std::cos(k * x) * std::sin(k * y),
                 sy = height * k * std::sin(k * x) * std::cos(k * y);
    const double unit = 1.0 / std::sqrt(1.0 + sx * sx + sy * sy);
    points.Add(x, y, height * std::sin(k * x) * std::sin(k * y) + across(random), -sx * unit, -sy * unit, unit);
  }
  return points;
}

TEST(NoiseProbeTest, TellsNormalsThatWereMadeOfThePositions) {
  for (const double sigma : {0.05, 0.1}) {
    const TestPoints torus = NoisyTorus(sigma);
    for (const uint32_t count : {16, 24, 30}) {
      const TestPoints fitted = WithFittedNormals(torus, NormalMethod::kPca, count);
      const std::optional<double> found = ProbedError(fitted);
      ASSERT_TRUE(found.has_value()) << sigma << " " << count;
      const double error = SquaredError(fitted, torus);
      EXPECT_GT(*found, 0.5 * error) << sigma << " " << count;
      EXPECT_LT(*found, 1.5 * error) << sigma << " " << count;
      EXPECT_EQ(found, ProbedError(fitted, true)) << "in whatever order";
    }
  }
}

TEST(NoiseProbeTest, TellsThoseOfMergedScans) {
  const TestPoints torus = NoisyTorus(0.05);
  EXPECT_TRUE(ProbedError(MergedScans(torus, 16)).has_value());
}

TEST(NoiseProbeTest, TellsSmoothedOnes) {
  for (const double sigma : {0.05, 0.1}) {
    const TestPoints planes = WithFittedNormals(NoisyTorus(sigma), NormalMethod::kPca, 14);
    EXPECT_TRUE(ProbedError(WithSmoothedNormals(planes, 0.36)).has_value()) << sigma;
  }
}

TEST(NoiseProbeTest, OtherNormalsAreNotToldWhateverTheirNoise) {
  for (const ProbedCloud& cloud : CloudsWithOtherNormals()) {
    EXPECT_FALSE(ProbedError(cloud.points).has_value()) << cloud.what;
  }
  const TestPoints torus = NoisyTorus(0.05);
  for (const float sigma : {0.02f, 0.1f, 0.3f})
    EXPECT_FALSE(ProbedError(WithNoisyNormals(torus, sigma)).has_value()) << sigma;
}

// Bends that neighborhoods cannot follow turn normals and planes alike, and are no noise.
TEST(NoiseProbeTest, BendsAreNoNoise) {
  for (const double length : {10.0, 14.0, 20.0, 30.0}) {
    for (const double noise : {0.05, 0.2, 0.6}) {
      for (const bool on_grid : {false, true}) {
        const TestPoints waves = Waves(length, noise, on_grid);
        EXPECT_FALSE(ProbedError(waves).has_value()) << length << " " << noise << " " << on_grid;
        EXPECT_FALSE(ProbedError(WithNoisyNormals(waves, 0.03f)).has_value())
            << length << " " << noise << " " << on_grid;
      }
      EXPECT_FALSE(ProbedError(Waves(length, noise, true, 0.3)).has_value()) << "lines " << length << " " << noise;
    }
  }
}

// Heights that are wrong in common, as where a scan is warped or rounded, look like bends that the normals lack.
TEST(NoiseProbeTest, ErrorsThatHeightsShareAreNotThoseOfNormals) {
  for (const float sigma : {0.0f, 0.02f}) {
    TestPoints rippled = WithNoisyNormals(Waves(40.0, 0.05, false), sigma);
    for (auto& [x, y, z] : rippled.positions) z += 0.1f * std::sin(0.25f * std::numbers::pi_v<float> * (x + 0.3f * y));
    EXPECT_FALSE(ProbedError(rippled).has_value()) << sigma;
    TestPoints rounded = WithNoisyNormals(Waves(40.0, 0.1, true), sigma);
    for (auto& position : rounded.positions) position[2] = std::round(position[2]);
    EXPECT_FALSE(ProbedError(rounded).has_value()) << sigma;
    TestPoints ramp = WithNoisyNormals(Waves(40.0, 0.0, false), sigma);
    std::mt19937 random(3);
    std::normal_distribution<float> across;
    for (auto& [x, y, z] : ramp.positions) z += (0.03f + 0.3f * x / 80.0f) * across(random);
    EXPECT_FALSE(ProbedError(ramp).has_value()) << sigma;
  }
}

TEST(NoiseProbeTest, ExactPositionsAreLookedAtInFewPlaces) {
  const NoiseFinding exact = ProbeNoise(Torus(8'000, 3)), noisy = ProbeNoise(NoisyTorus(0.02));
  EXPECT_FALSE(exact.squared_error.has_value());
  EXPECT_GT(exact.block_count, 0u);
  EXPECT_LT(4 * exact.block_count, noisy.block_count);
}

TEST(NoiseProbeTest, SmallCloudsTellNothing) {
  const SpatialIndex index = BuildIndex(Sphere(3 * NoiseProbe::kNeighbors - 1, 1.0).ToCloud());
  NoiseProbe probe(index, 10'000, 1);
  EXPECT_FALSE(probe.AddBlocks());
  EXPECT_FALSE(probe.SquaredError().has_value());
  EXPECT_EQ(NoiseProbe::ScratchBytes(index.point_count(), 10'000), 0u);
  EXPECT_EQ(NoiseProbe::ScratchBytes(1'000'000, NoiseProbe::kNeighbors - 1), 0u);
  EXPECT_GT(NoiseProbe::ScratchBytes(1'000'000, NoiseProbe::kNeighbors), 0u);
}

TEST(NoiseProbeTest, EndsWhereItIsStopped) {
  const SpatialIndex index = BuildIndex(NoisyTorus(0.05).ToCloud());
  NoiseProbe probe(index, 10'000, 1);
  const std::atomic<bool> stopped = true;
  EXPECT_EQ(probe.RunBlock(0, 0, stopped).code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace curvd::testing
