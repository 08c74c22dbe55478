#include "tests/core/normals/normal_clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <utility>

#include "core/estimators/triangles/random_stream.h"
#include "core/normals/runs/half_normals.h"
#include "core/normals/runs/normal_fit_run.h"
#include "core/normals/runs/normal_refit.h"
#include "tests/core/estimators/run_in_parts.h"

namespace curvd::testing {
namespace {

double Uniform(RandomStream& random) { return static_cast<double>(random.Next() >> 11) * 0x1p-53; }

double Gaussian(RandomStream& random) {
  const double u = 1.0 - Uniform(random), v = Uniform(random);
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}

double Dot(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  return static_cast<double>(a[0]) * b[0] + static_cast<double>(a[1]) * b[1] + static_cast<double>(a[2]) * b[2];
}

}  // namespace

TestPoints ScannedSaddle(size_t points, double gap, double noise, uint64_t seed) {
  const int on_line = static_cast<int>(std::sqrt(static_cast<double>(points) * gap));
  const int lines = static_cast<int>(points) / on_line;
  const double step = 2.0 / on_line;
  RandomStream random(seed, 0);
  TestPoints saddle;
  for (int line = 0; line < lines; ++line) {
    const double y = 2.0 * (line + 0.5) / lines - 1.0;
    for (int i = 0; i < on_line; ++i) {
      const double x = (i + 0.5) * step - 1.0, length = std::sqrt(1.0 + x * x + y * y);
      const double off = noise * step * Gaussian(random);
      const double nx = -x / length, ny = y / length, nz = 1.0 / length;
      saddle.Add(x + off * nx, y + off * ny, 0.5 * (x * x - y * y) + off * nz, nx, ny, nz);
    }
  }
  return saddle;
}

TestPoints ScannedEllipsoid(double sigma, uint64_t seed) {
  constexpr int kLines = 30, kOnLine = 489;
  TestPoints ellipsoid;
  RandomStream random(seed, 0);
  for (int line = 0; line < kLines; ++line) {
    const double h = 2.0 * (line + 0.5) / kLines - 1.0, away = std::sqrt(1.0 - h * h);
    for (int i = 0; i < kOnLine; ++i) {
      const double turn = 2.0 * std::numbers::pi * (i + 0.5) / kOnLine;
      const double x = away * std::cos(turn), y = 0.7 * away * std::sin(turn), z = 0.4 * h;
      const double length = std::hypot(x, y / 0.49, z / 0.16);
      const double nx = x / length, ny = y / 0.49 / length, nz = z / 0.16 / length, off = sigma * Gaussian(random);
      ellipsoid.Add(x + off * nx, y + off * ny, z + off * nz, nx, ny, nz);
    }
  }
  return ellipsoid;
}

bool IsFarOff(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  return std::abs(Dot(a, b)) < std::cos(std::numbers::pi / 12.0);
}

TestPoints Torus(size_t points, uint64_t seed) {
  TestPoints torus;
  for (uint64_t i = 0; torus.size() < points; ++i) {
    RandomStream random(seed, i);
    const double u = 2.0 * std::numbers::pi * Uniform(random), v = 2.0 * std::numbers::pi * Uniform(random);
    if (Uniform(random) > (6.0 + 2.0 * std::cos(v)) / 8.0) continue;
    const double nx = std::cos(u) * std::cos(v), ny = std::sin(u) * std::cos(v), nz = std::sin(v);
    torus.Add(6.0 * std::cos(u) + 2.0 * nx, 6.0 * std::sin(u) + 2.0 * ny, 2.0 * nz, nx, ny, nz);
  }
  return torus;
}

TestPoints ClosedPlate(size_t points, double thickness, uint64_t seed) {
  TestPoints plate;
  const double spacing = std::sqrt((8.0 + 8.0 * thickness) / static_cast<double>(points));
  uint64_t stream = 0;
  // Faces at `at` on `axis`, of size[0] x size[1] on the two axes that follow.
  const auto add_face = [&](size_t axis, double at, double side, double first, double second) {
    const auto rows = static_cast<size_t>(std::max(1.0, std::round(first / spacing)));
    const auto columns = static_cast<size_t>(std::max(1.0, std::round(second / spacing)));
    for (size_t i = 0; i < rows * columns; ++i) {
      RandomStream random(seed, stream++);
      const auto shaken = [&](size_t cell) { return static_cast<double>(cell) + 0.5 + 0.7 * (Uniform(random) - 0.5); };
      double position[3], normal[3] = {};
      position[axis] = at;
      position[(axis + 1) % 3] = shaken(i / columns) * first / static_cast<double>(rows);
      position[(axis + 2) % 3] = shaken(i % columns) * second / static_cast<double>(columns);
      normal[axis] = side;
      plate.Add(position[0], position[1], position[2], normal[0], normal[1], normal[2]);
    }
  };
  for (const double side : {-1.0, 1.0}) {
    add_face(2, side > 0.0 ? thickness : 0.0, side, 2.0, 2.0);
    add_face(0, side > 0.0 ? 2.0 : 0.0, side, 2.0, thickness);
    add_face(1, side > 0.0 ? 2.0 : 0.0, side, thickness, 2.0);
  }
  return plate;
}

void AddNoise(double sigma, uint64_t seed, TestPoints& points) {
  for (size_t i = 0; i < points.size(); ++i) {
    RandomStream random(seed, i);
    for (float& coordinate : points.positions[i]) coordinate += static_cast<float>(sigma * Gaussian(random));
  }
}

void Shift(double x, double y, double z, TestPoints& points) {
  for (auto& p : points.positions) {
    p = {static_cast<float>(p[0] + x), static_cast<float>(p[1] + y), static_cast<float>(p[2] + z)};
  }
}

void Append(const TestPoints& more, TestPoints& points) {
  points.positions.insert(points.positions.end(), more.positions.begin(), more.positions.end());
  points.normals.insert(points.normals.end(), more.normals.begin(), more.normals.end());
}

Cloud BareCloud(const TestPoints& points) {
  Cloud cloud(ScalarType::kFloat32, InvalidPointPolicy::kSkip, NormalsInput::kAbsent);
  const size_t bytes = points.size() * sizeof(points.positions[0]);
  const absl::Status appended = cloud.Append({reinterpret_cast<const char*>(points.positions.data()), bytes}, {});
  EXPECT_TRUE(appended.ok()) << appended;
  EXPECT_TRUE(cloud.Finish().ok());
  return cloud;
}

NormalResult MustMakeNormals(Cloud cloud, const NormalOptions& options, int threads) {
  WorkerPool pool(threads);
  auto result = MakeNormals(std::move(cloud), options, pool);
  EXPECT_TRUE(result.ok()) << result.status();
  return result.ok() ? *std::move(result) : NormalResult{};
}

NormalOptions Estimated() {
  NormalOptions options;
  options.source = NormalSource::kEstimate;
  return options;
}

NormalOptions EstimateBy(NormalMethod method, uint32_t count) {
  NormalOptions options;
  options.source = NormalSource::kEstimate;
  options.method = method;
  options.neighborhood = NeighborCount{count};
  return options;
}

void MakeHalfNormals(SpatialIndex& index, const NormalFit& fit, uint64_t most_work) {
  EXPECT_TRUE(index.MakeHalfNormals().ok());
  RunInParts(*StartHalfNormals(fit, index), index, most_work);
}

void RefitNormals(SpatialIndex& index, const NormalFit& fit, uint64_t most_work) {
  EXPECT_TRUE(index.MakeHalfNormals().ok());
  RunInParts(*StartNormalRefit(fit, index), index, most_work);
}

PlacedNormals MakeByPlace(SpatialIndex& index, const NormalFit& fit, uint64_t most_work) {
  NormalQuality quality;
  EXPECT_TRUE(quality.Create(index.leaf_count() * SpatialIndex::kLeafSize, true).ok());
  const std::unique_ptr<StrategyRun> run = StartNormalFit(fit, index, quality);
  RunInParts(*run, index, most_work);
  PlacedNormals made;
  for (size_t place = 0; place < index.point_count(); ++place) {
    const SpatialIndex::LeafNormals& n = index.normals(place / SpatialIndex::kLeafSize);
    const size_t lane = place % SpatialIndex::kLeafSize;
    made.normals.push_back({n.x[lane], n.y[lane], n.z[lane]});
    made.statuses.push_back(quality.status[place]);
    made.residuals.push_back(quality.residual[place]);
    made.variance_ratios.push_back(quality.variance_ratio[place]);
  }
  return made;
}

size_t CountKeptByHalves(const SpatialIndex& index, const PlacedNormals& made) {
  size_t kept = 0;
  for (size_t place = 0; place < index.point_count(); ++place) {
    const SpatialIndex::LeafNormals& halves = index.half_normals(place / SpatialIndex::kLeafSize);
    const size_t lane = place % SpatialIndex::kLeafSize;
    kept += std::array{halves.x[lane], halves.y[lane], halves.z[lane]} == made.normals[place] ? 1 : 0;
  }
  return kept;
}

void ExpectSameNormalsInParts(const TestPoints& points, const NormalFit& fit) {
  SpatialIndex whole = BuildIndex(points.ToCloud()), in_parts = BuildIndex(points.ToCloud());
  EXPECT_EQ(MakeByPlace(whole, fit).normals, MakeByPlace(in_parts, fit, 1).normals);
  MakeHalfNormals(whole, fit);
  MakeHalfNormals(in_parts, fit, 1);
  for (size_t leaf = 0; leaf < whole.leaf_count(); ++leaf) {
    const SpatialIndex::LeafNormals &a = whole.half_normals(leaf), &b = in_parts.half_normals(leaf);
    for (int lane = 0; lane < whole.LeafPoints(leaf); ++lane) {
      ASSERT_EQ((std::array{a.x[lane], a.y[lane], a.z[lane]}), (std::array{b.x[lane], b.y[lane], b.z[lane]})) << leaf;
    }
  }
}

double MeanAngle(const NormalField& normals, const TestPoints& points) {
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < points.size(); ++i) {
    if (normals[i].status != PointStatus::kOk) continue;
    sum += std::acos(std::min(std::abs(Dot(normals[i].normal, points.normals[i])), 1.0));
    ++count;
  }
  return sum / count * 180.0 / std::numbers::pi;
}

double FlippedShare(const NormalField& normals, const TestPoints& points) {
  double flipped = 0.0, count = 0.0;
  for (size_t i = 0; i < points.size(); ++i) {
    if (normals[i].status != PointStatus::kOk) continue;
    flipped += Dot(normals[i].normal, points.normals[i]) < 0.0 ? 1.0 : 0.0;
    ++count;
  }
  return flipped / count;
}

bool SameBytes(const NormalField& a, const NormalField& b) {
  if (a.size() != b.size()) return false;
  for (size_t i = 0; i < a.size(); ++i) {
    if (std::memcmp(&a[i], &b[i], offsetof(PointNormal, status)) != 0 || a[i].status != b[i].status) return false;
  }
  return true;
}

}  // namespace curvd::testing
