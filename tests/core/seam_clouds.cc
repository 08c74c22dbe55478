#include "tests/core/seam_clouds.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/estimators/triangles/random_stream.h"

namespace curvd::testing {
namespace {

using Vector = std::array<double, 3>;

class Draws {
 public:
  Draws(uint64_t seed, uint64_t id) : random_(seed, id) {}
  // In [0, 1).
  double Uniform() { return static_cast<double>(random_.Next() >> 11) * 0x1p-53; }
  double Gaussian() {
    const double length = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
    return length * std::cos(2.0 * std::numbers::pi * Uniform());
  }
  Vector Direction() {
    const double z = 2.0 * Uniform() - 1.0, angle = 2.0 * std::numbers::pi * Uniform(), ring = std::sqrt(1.0 - z * z);
    return {ring * std::cos(angle), ring * std::sin(angle), z};
  }

 private:
  RandomStream random_;
};

void Add(const Vector& position, Vector normal, TestPoints& points) {
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  for (double& component : normal) component /= length;
  points.Add(position[0], position[1], position[2], normal[0], normal[1], normal[2]);
}

Vector Scaled(const Vector& v, double s) { return {v[0] * s, v[1] * s, v[2] * s}; }

// The distance of points that are spread evenly over an area.
double Spacing(double area, size_t points) { return std::sqrt(area / static_cast<double>(points)); }

void Negate(std::array<float, 3>& v) {
  for (float& component : v) component = -component;
}

}  // namespace

TestPoints RandomSphere(size_t points, double radius, uint64_t seed) {
  TestPoints sphere;
  for (size_t i = 0; i < points; ++i) {
    const Vector direction = Draws(seed, i).Direction();
    Add(Scaled(direction, radius), direction, sphere);
  }
  return sphere;
}

TestPoints RandomTorus(size_t points, uint64_t seed) {
  TestPoints torus;
  for (size_t i = 0; i < points; ++i) {
    Draws draws(seed, i);
    double around = 0.0, reach = 0.0;
    do {  // the outer half has more area
      around = 2.0 * std::numbers::pi * draws.Uniform();
      reach = 2.0 + std::cos(around);
    } while (3.0 * draws.Uniform() > reach);
    const double along = 2.0 * std::numbers::pi * draws.Uniform();
    const double out = std::cos(around), up = std::sin(around);
    Add({reach * std::cos(along), reach * std::sin(along), up}, {out * std::cos(along), out * std::sin(along), up},
        torus);
  }
  return torus;
}

TestPoints Plate(size_t points, double thickness, uint64_t seed) {
  TestPoints plate;
  const double half = thickness * Spacing(8.0, points) / 2.0;
  for (size_t i = 0; i < points; ++i) {
    Draws draws(seed, i);
    const double x = 2.0 * draws.Uniform(), y = 2.0 * draws.Uniform(), side = i % 2 == 0 ? 1.0 : -1.0;
    Add({x, y, side * half}, {0.0, 0.0, side}, plate);
  }
  return plate;
}

TestPoints Shell(size_t points, double thickness, uint64_t seed) {
  TestPoints shell;
  const double inner = 1.0 - thickness * Spacing(8.0 * std::numbers::pi, points);
  for (size_t i = 0; i < points; ++i) {
    const Vector direction = Draws(seed, i).Direction();
    i % 2 == 0 ? Add(direction, direction, shell) : Add(Scaled(direction, inner), Scaled(direction, -1.0), shell);
  }
  return shell;
}

TestPoints Wedge(size_t points, double degrees, uint64_t seed) {
  TestPoints wedge;
  const double half = degrees / 2.0 * std::numbers::pi / 180.0;
  for (size_t i = 0; i < points; ++i) {
    Draws draws(seed, i);
    const double x = draws.Uniform(), z = 4.0 * draws.Uniform(), side = i % 2 == 0 ? 1.0 : -1.0;
    Add({x * std::cos(half), side * x * std::sin(half), z}, {-std::sin(half), side * std::cos(half), 0.0}, wedge);
  }
  return wedge;
}

TestPoints Lens(size_t points, double thickness, uint64_t seed) {
  TestPoints lens;
  const double flat = thickness * Spacing(2.0 * std::numbers::pi, points) / 2.0;
  for (size_t i = 0; i < points; ++i) {
    Draws draws(seed, i);
    Vector direction{}, normal{};
    do {  // what is flattened has less area
      direction = draws.Direction();
      normal = {direction[0] * flat, direction[1] * flat, direction[2]};
    } while (draws.Uniform() > std::hypot(normal[0], normal[1], normal[2]));
    Add({direction[0], direction[1], direction[2] * flat}, normal, lens);
  }
  return lens;
}

void AddNoise(double position, double normal, uint64_t seed, TestPoints& points) {
  for (size_t i = 0; i < points.size(); ++i) {
    Draws draws(seed, i);
    float squared = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      points.positions[i][axis] += static_cast<float>(position * draws.Gaussian());
      points.normals[i][axis] += static_cast<float>(normal * draws.Gaussian());
      squared += points.normals[i][axis] * points.normals[i][axis];
    }
    for (float& component : points.normals[i]) component /= std::sqrt(squared);
  }
}

Flips FlipAtRandom(double share, uint64_t seed, TestPoints& points) {
  Flips flips(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    flips[i] = Draws(seed, i).Uniform() < share ? 1 : 0;
    if (flips[i] != 0) Negate(points.normals[i]);
  }
  return flips;
}

Flips FlipWhere(const std::function<bool(const std::array<float, 3>&)>& where, TestPoints& points) {
  Flips flips(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    flips[i] = where(points.positions[i]) ? 1 : 0;
    if (flips[i] != 0) Negate(points.normals[i]);
  }
  return flips;
}

std::vector<size_t> OkAcrossSeams(const TestPoints& points, const Flips& flips, const CurvatureField& field,
                                  const std::vector<char>& sheets) {
  // In the order of x, so that few have to be looked at for each point.
  const auto x_of = [&](size_t i) { return double{points.positions[i][0]}; };
  std::vector<size_t> by_x(points.size());
  std::iota(by_x.begin(), by_x.end(), size_t{0});
  std::sort(by_x.begin(), by_x.end(), [&](size_t i, size_t j) { return x_of(i) < x_of(j); });
  std::vector<size_t> wrong;
  for (size_t i = 0; i < points.size(); ++i) {
    if (field.points[i].status != PointStatus::kOk) continue;
    const double reach = field.points[i].radius;
    const auto begin =
        std::lower_bound(by_x.begin(), by_x.end(), x_of(i) - reach, [&](size_t j, double x) { return x_of(j) < x; });
    std::array<std::array<bool, 2>, 2> seen{};  // by sheet, by flip
    for (auto near = begin; near != by_x.end() && x_of(*near) <= x_of(i) + reach; ++near) {
      const size_t j = *near;
      if (field.points[j].status == PointStatus::kOutlier) continue;  // nobody's neighbor
      double squared = 0.0;
      for (int axis = 0; axis < 3; ++axis) {
        const double d = double{points.positions[j][axis]} - points.positions[i][axis];
        squared += d * d;
      }
      if (squared <= reach * reach) seen[sheets.empty() ? 0 : sheets[j]][flips[j]] = true;
    }
    if ((seen[0][0] && seen[0][1]) || (seen[1][0] && seen[1][1])) wrong.push_back(i);
  }
  return wrong;
}

}  // namespace curvd::testing
