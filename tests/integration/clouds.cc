#include "tests/integration/clouds.h"

#include <cmath>
#include <numbers>

namespace curvd {
namespace {

constexpr double kPi = std::numbers::pi;
// The additive recurrence with the least discrepancy in two dimensions: reciprocals of the plastic number.
constexpr double kStepU = 0.7548776662466927;
constexpr double kStepV = 0.5698402909980532;

double Fraction(double x) { return x - std::floor(x); }

std::string Pack(const std::vector<float>& values, size_t first, size_t count) {
  if (values.empty()) return "";
  return std::string(reinterpret_cast<const char*>(values.data() + 3 * first), 3 * count * sizeof(float));
}

}  // namespace

void TestCloud::Add(float x, float y, float z, float nx, float ny, float nz) {
  positions.insert(positions.end(), {x, y, z});
  normals.insert(normals.end(), {nx, ny, nz});
}

std::string TestCloud::PackedPositions(size_t first, size_t count) const { return Pack(positions, first, count); }
std::string TestCloud::PackedNormals(size_t first, size_t count) const { return Pack(normals, first, count); }
std::string TestCloud::PackedViewpoints(size_t first, size_t count) const { return Pack(viewpoints, first, count); }

TestCloud Sphere(size_t count, float radius) {
  TestCloud cloud;
  const double golden_angle = kPi * (3.0 - std::sqrt(5.0));
  for (size_t i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
    const double ring = std::sqrt(1.0 - z * z);
    const double angle = golden_angle * static_cast<double>(i);
    const float nx = static_cast<float>(ring * std::cos(angle));
    const float ny = static_cast<float>(ring * std::sin(angle));
    const float nz = static_cast<float>(z);
    cloud.Add(radius * nx, radius * ny, radius * nz, nx, ny, nz);
  }
  return cloud;
}

TestCloud Torus(size_t count) {
  TestCloud cloud;
  for (size_t i = 0; i < count; ++i) {
    const double u = 2.0 * kPi * Fraction(0.5 + kStepU * static_cast<double>(i + 1));
    const double v = 2.0 * kPi * Fraction(0.5 + kStepV * static_cast<double>(i + 1));
    const double nx = std::cos(v) * std::cos(u), ny = std::cos(v) * std::sin(u), nz = std::sin(v);
    cloud.Add(static_cast<float>(2.0 * std::cos(u) + nx), static_cast<float>(2.0 * std::sin(u) + ny),
              static_cast<float>(nz), static_cast<float>(nx), static_cast<float>(ny), static_cast<float>(nz));
  }
  return cloud;
}

TestCloud Square(size_t count) {
  TestCloud cloud;
  for (size_t i = 0; i < count; ++i) {
    cloud.Add(static_cast<float>(Fraction(kStepU * static_cast<double>(i + 1))),
              static_cast<float>(Fraction(kStepV * static_cast<double>(i + 1))), 0.0f, 0.0f, 0.0f, 1.0f);
  }
  return cloud;
}

}  // namespace curvd
