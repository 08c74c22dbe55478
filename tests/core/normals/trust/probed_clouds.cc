#include "tests/core/normals/trust/probed_clouds.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"

namespace curvd::testing {
namespace {

constexpr size_t kProbedPoints = kSanitized ? 3'000 : 8'000;

void AddNormalNoise(double sigma, TestPoints& points) {
  TestPoints moved;
  moved.positions = points.normals;
  AddNoise(sigma, 7, moved);
  for (size_t i = 0; i < points.size(); ++i) {
    const auto& n = moved.positions[i];
    const float length = std::hypot(n[0], n[1], n[2]);
    points.normals[i] = {n[0] / length, n[1] / length, n[2] / length};
  }
}

// Rings of a scan around a cylinder; or one strip of it, with some width.
TestPoints Rings(double width) {
  TestPoints rings;
  for (size_t i = 0; i < 4'000; ++i) {
    const double turn = 2.39996 * static_cast<double>(i), height = width * (static_cast<double>(i % 97) / 97.0 - 0.5);
    rings.Add(std::cos(turn), std::sin(turn), width > 0.0 ? height : 0.125 * static_cast<double>(i % 16),
              std::cos(turn), std::sin(turn), 0.0);
  }
  return rings;
}

// A cylinder on a grid: planes of whole rings of neighbors have the exact normals.
TestPoints GridOnCylinder(double stretch) {
  TestPoints grid;
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 40; ++j) {
      const double turn = 2.0 * 3.14159265358979 * i / 100.0;
      grid.Add(std::cos(turn), std::sin(turn), stretch * 0.0628 * j, std::cos(turn), std::sin(turn), 0.0);
    }
  }
  return grid;
}

// Nine points to a wave.
TestPoints FastWaves() {
  TestPoints waves;
  for (int i = 0; i < 3'600; ++i) {
    const int row = i / 60, column = i % 60;
    const double x = column / 30.0 - 1.0, y = row / 30.0 - 1.0, f = 20.0;
    const double dx = -0.4 * std::cos(f * x) * std::cos(f * y), dy = 0.4 * std::sin(f * x) * std::sin(f * y);
    const double length = std::sqrt(1.0 + dx * dx + dy * dy);
    waves.Add(x, y, 0.4 / f * std::sin(f * x) * std::cos(f * y), dx / length, dy / length, 1.0 / length);
  }
  return waves;
}

TestPoints Shell(double gap) {
  TestPoints shell = Sphere(2'000, 1.0), inner = Sphere(2'000, 1.0 - gap);
  for (auto& normal : inner.normals) normal = {-normal[0], -normal[1], -normal[2]};
  Append(inner, shell);
  return shell;
}

}  // namespace

TestPoints TorusWithNoise(double sigma) {
  TestPoints torus = Torus(kProbedPoints, 5);
  AddNoise(sigma, 6, torus);
  return torus;
}

TestPoints WithFittedNormals(TestPoints points, const NormalOptions& how) {
  const NormalResult made = MustMakeNormals(BareCloud(points), how);
  for (size_t i = 0; i < points.size(); ++i) {
    if (made.normals[i].status != PointStatus::kOk) continue;
    std::array<float, 3> normal = made.normals[i].normal;
    const float side =
        normal[0] * points.normals[i][0] + normal[1] * points.normals[i][1] + normal[2] * points.normals[i][2];
    if (side < 0.0f) normal = {-normal[0], -normal[1], -normal[2]};
    points.normals[i] = normal;
  }
  return points;
}

TestPoints WithFittedNormals(TestPoints points, NormalMethod method, uint32_t count) {
  return WithFittedNormals(std::move(points), EstimateBy(method, count));
}

std::vector<ProbedCloud> CloudsWithOtherNormals() {
  std::vector<ProbedCloud> clouds;
  const auto add = [&](std::string what, TestPoints points, double sigma) {
    AddNoise(sigma, 4, points);
    clouds.push_back({absl::StrCat(what, ", noise ", sigma), std::move(points)});
  };
  for (const double sigma : {0.0, 0.003, 0.02, 0.1, 0.3}) {
    add("torus", TorusWithNoise(0.0), sigma);
    add("waves", Waves(kProbedPoints, 0.0, 8), sigma / 20.0);
    add("few points of waves", Waves(600, 0.0, 9), sigma / 20.0);
  }
  for (const double sigma : {0.003, 0.02, 0.1}) {
    for (const double of_normals : {0.01, 0.05, 0.2}) {
      TestPoints torus = TorusWithNoise(0.0);
      AddNormalNoise(of_normals, torus);
      add(absl::StrCat("torus whose normals are off by ", of_normals), torus, sigma);
    }
  }
  for (const double sigma : {0.0, 0.0005, 0.002, 0.005}) {
    add("rings", Rings(0.0), sigma);
    for (const double width : {0.005, 0.02}) add(absl::StrCat("strip of width ", width), Rings(width), sigma);
    for (const double gap : {0.05, 0.1, 0.2}) add(absl::StrCat("shell of thickness ", gap), Shell(gap), sigma);
    for (const double stretch : {1.0, 0.8})
      add(absl::StrCat("grid stretched by ", stretch), GridOnCylinder(stretch), sigma);
    add("fast waves", FastWaves(), 2.0 * sigma);
  }
  for (const double sigma : {1e-7, 1e-6, 1e-5, 1e-4}) add("grid", GridOnCylinder(1.0), sigma);
  // Noise of their own outweighs what such normals share.
  TestPoints both = WithFittedNormals(TorusWithNoise(0.01), NormalMethod::kPca, 20);
  AddNormalNoise(0.2, both);
  clouds.push_back({"planes with noise of their own", std::move(both)});
  return clouds;
}

}  // namespace curvd::testing
