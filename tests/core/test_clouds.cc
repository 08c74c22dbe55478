#include "tests/core/test_clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <utility>
#include <vector>

#include "core/estimators/triangles/random_stream.h"
#include "core/index/index_builder.h"

namespace curvd::testing {
namespace {

// Uniform in [0, 1).
double Uniform(RandomStream& random) { return static_cast<double>(random.Next() >> 11) * 0x1p-53; }

std::array<double, 3> LayoutPosition(Layout layout, size_t i, RandomStream& random) {
  const double x = Uniform(random), y = Uniform(random), z = Uniform(random);
  switch (layout) {
    case Layout::kUniform:
      return {x, y, z};
    case Layout::kClustered: {
      const double spread = i % 2 == 0 ? 1.0 : 1e-4;
      return {0.3 + spread * (x - 0.5), 0.6 + spread * (y - 0.5), spread * z};
    }
    case Layout::kCollinear:
      return {x, 2 * x, 3 * x};
    case Layout::kCoplanar:
      return {x, y, 0.5};
    case Layout::kDuplicates:
      return {std::floor(x * 4), std::floor(y * 4), std::floor(z * 4)};
    case Layout::kLattice:
      return {static_cast<double>(i % 12), static_cast<double>(i / 12 % 12), static_cast<double>(i / 144)};
    case Layout::kAnisotropic:
      return {x * 1e4, y, z * 1e-4};
    case Layout::kOutlier:
      return i == 7 ? std::array<double, 3>{1e6, 1e6, 1e6} : std::array<double, 3>{x, y, z};
  }
  return {};
}

}  // namespace

void TestPoints::Add(double x, double y, double z, double nx, double ny, double nz) {
  positions.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  normals.push_back({static_cast<float>(nx), static_cast<float>(ny), static_cast<float>(nz)});
}

Cloud TestPoints::ToCloud(Size size) const {
  Cloud cloud(ScalarType::kFloat32, InvalidPointPolicy::kSkip);
  if (size == Size::kExpected) cloud.Expect(positions.size());
  const size_t bytes = positions.size() * sizeof(positions[0]);
  const absl::Status appended = cloud.Append({reinterpret_cast<const char*>(positions.data()), bytes},
                                             {reinterpret_cast<const char*>(normals.data()), bytes});
  EXPECT_TRUE(appended.ok()) << appended;
  EXPECT_TRUE(cloud.Finish().ok());
  return cloud;
}

TestPoints Sphere(size_t points, double radius) {
  const double golden_angle = std::numbers::pi * (3.0 - std::sqrt(5.0));
  TestPoints sphere;
  for (size_t i = 0; i < points; ++i) {
    const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(points);
    const double r = std::sqrt(1.0 - z * z);
    const double x = r * std::cos(golden_angle * static_cast<double>(i));
    const double y = r * std::sin(golden_angle * static_cast<double>(i));
    sphere.Add(radius * x, radius * y, radius * z, x, y, z);
  }
  return sphere;
}

TestPoints Pipe(size_t points, uint64_t seed) {
  const double root = std::sqrt(0.5);
  TestPoints pipe;
  for (size_t i = 0; i < points; ++i) {
    RandomStream random(seed, i);
    const double along = 20.0 * Uniform(random) - 10.0, angle = 2.0 * std::numbers::pi * Uniform(random);
    const double x = std::cos(angle), y = std::sin(angle);
    pipe.Add(0.5 * x, root * (0.5 * y + along), root * (along - 0.5 * y), x, root * y, -root * y);
  }
  return pipe;
}

TestPoints Waves(size_t points, double noise, uint64_t seed) {
  TestPoints waves;
  for (size_t i = 0; i < points; ++i) {
    RandomStream random(seed, i);
    const double x = Uniform(random), y = Uniform(random);
    const auto moved = [&](double coordinate) { return coordinate + noise * (2.0 * Uniform(random) - 1.0); };
    const double slope_x = 0.8 * std::cos(4.0 * x) * std::cos(3.0 * y);
    const double slope_y = -0.6 * std::sin(4.0 * x) * std::sin(3.0 * y);
    const double length = std::sqrt(slope_x * slope_x + slope_y * slope_y + 1.0);
    waves.Add(moved(x), moved(y), moved(0.2 * std::sin(4.0 * x) * std::cos(3.0 * y)), -slope_x / length,
              -slope_y / length, 1.0 / length);
  }
  return waves;
}

std::string LayoutName(Layout layout) {
  constexpr const char* kNames[] = {"Uniform",    "Clustered", "Collinear",   "Coplanar",
                                    "Duplicates", "Lattice",   "Anisotropic", "Outlier"};
  return kNames[static_cast<int>(layout)];
}

TestPoints RandomPoints(Layout layout, size_t points, uint64_t seed) {
  TestPoints result;
  for (size_t i = 0; i < points; ++i) {
    RandomStream random(seed, i);
    const auto position = LayoutPosition(layout, i, random);
    const double nx = 0.6 * (Uniform(random) - 0.5), ny = 0.6 * (Uniform(random) - 0.5);
    const double length = std::sqrt(nx * nx + ny * ny + 1.0);
    result.Add(position[0], position[1], position[2], nx / length, ny / length, 1.0 / length);
  }
  return result;
}

SpatialIndex BuildIndex(Cloud cloud) {
  IndexBuilder builder(std::move(cloud));
  EXPECT_TRUE(builder.Start().ok());
  while (builder.block_count() > 0) {
    // Backwards: the order of blocks must not matter.
    for (size_t block = builder.block_count(); block-- > 0;) builder.RunBlock(block);
    builder.EndPhase();
  }
  std::vector<IndexBuilder::Part> open = {builder.root()};
  while (!open.empty()) {
    const IndexBuilder::Part part = open.back();
    open.pop_back();
    builder.Build(part, [&](const IndexBuilder::Part& half) { open.push_back(half); });
  }
  return builder.Take();
}

EstimationResult MustEstimate(Cloud cloud, const EstimatorOptions& options, int threads) {
  WorkerPool pool(threads);
  auto result = EstimateCurvature(std::move(cloud), options, pool);
  EXPECT_TRUE(result.ok()) << result.status();
  return result.ok() ? *std::move(result) : EstimationResult{};
}

size_t FirstDifference(std::span<const PointCurvature> a, std::span<const PointCurvature> b) {
  const auto differs = [&](size_t i, const Column& column) {
    const auto at = [&](const PointCurvature& point) { return reinterpret_cast<const char*>(&point) + column.offset; };
    return std::memcmp(at(a[i]), at(b[i]), column.bytes()) != 0;
  };
  size_t i = 0;
  while (i < a.size() && std::ranges::none_of(kColumns, [&](const Column& column) { return differs(i, column); })) ++i;
  return i;
}

}  // namespace curvd::testing
