#include "tests/core/hostile_clouds.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace curvd::testing {
namespace {

using Vector = std::array<float, 3>;
using Vectors = std::vector<Vector>;

// A generator of its own, so that the clouds are the same with every standard library.
class Draws {
 public:
  // In [0, 1).
  double Next() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state_ >> 11) * 0x1p-53;
  }
  // Evenly spread over the unit sphere.
  std::array<double, 3> Direction() {
    const double z = 2.0 * Next() - 1.0, angle = 2.0 * std::numbers::pi * Next(), ring = std::sqrt(1.0 - z * z);
    return {ring * std::cos(angle), ring * std::sin(angle), z};
  }

 private:
  uint64_t state_ = 1;
};

void Add(std::array<double, 3> position, std::array<double, 3> normal, Vectors& positions, Vectors& normals) {
  Vector p, n;
  for (int axis = 0; axis < 3; ++axis) {
    p[axis] = static_cast<float>(position[axis]);
    n[axis] = static_cast<float>(normal[axis]);
  }
  positions.push_back(p);
  normals.push_back(n);
}

std::array<double, 3> Scaled(std::array<double, 3> v, double factor) {
  return {v[0] * factor, v[1] * factor, v[2] * factor};
}

// Points on spheres around the origin: `radius(i)` is that of point i.
template <typename Radius>
void OnSpheres(size_t points, Vectors& positions, Vectors& normals, Radius radius) {
  Draws draws;
  for (size_t i = 0; i < points; ++i) {
    const std::array<double, 3> direction = draws.Direction();
    Add(Scaled(direction, radius(i)), direction, positions, normals);
  }
}

// Points at `place(i, draws)` whose normals are near +z.
template <typename Place>
void Upward(size_t points, Vectors& positions, Vectors& normals, Place place) {
  Draws draws;
  for (size_t i = 0; i < points; ++i) {
    const std::array<double, 3> position = place(i, draws);
    const double x = 0.1 * (draws.Next() - 0.5), y = 0.1 * (draws.Next() - 0.5);
    Add(position, {x, y, std::sqrt(1.0 - x * x - y * y)}, positions, normals);
  }
}

void AllEqual(size_t points, Vectors& positions, Vectors& normals) {
  Upward(points, positions, normals, [](size_t, Draws&) { return std::array{1.0, 2.0, 3.0}; });
}

// As scanners write what did not return.
void HalfAtZero(size_t points, Vectors& positions, Vectors& normals) {
  OnSpheres(points, positions, normals, [](size_t i) { return i % 2 == 0 ? 0.0 : 1.0; });
}

void OutlierAt(double far, size_t points, Vectors& positions, Vectors& normals) {
  OnSpheres(points, positions, normals, [=](size_t i) { return i == points / 2 ? far : 1.0; });
}
void OutlierAt5e20(size_t points, Vectors& p, Vectors& n) { OutlierAt(5e20, points, p, n); }
void OutlierAt1e30(size_t points, Vectors& p, Vectors& n) { OutlierAt(1e30, points, p, n); }

void TinyBesideUnit(size_t points, Vectors& positions, Vectors& normals) {
  OnSpheres(points, positions, normals, [](size_t i) { return i % 2 == 0 ? 1e-20 : 1.0; });
}

void EveryMagnitude(size_t points, Vectors& positions, Vectors& normals) {
  Draws draws;
  OnSpheres(points, positions, normals, [&](size_t) { return std::pow(10.0, 70.0 * draws.Next() - 35.0); });
}

void TwoFarClusters(size_t points, Vectors& positions, Vectors& normals) {
  OnSpheres(points, positions, normals, [](size_t) { return 1.0; });
  for (size_t i = 0; i < points; i += 2) positions[i][0] += 1e5f;
}

// Of an even sphere one point in 20, and as many places nearby taken by all others.
void DenseInSparse(size_t points, Vectors& positions, Vectors& normals) {
  OnSpheres(points, positions, normals, [](size_t i) { return i % 20 == 0 ? 1.0 : 1e-5; });
}

void OnLine(size_t points, Vectors& positions, Vectors& normals) {
  Upward(points, positions, normals, [](size_t, Draws& draws) {
    const double at = draws.Next();
    return std::array{at, 2.0 * at, 3.0 * at};
  });
}

void GeometricSpacing(size_t points, Vectors& positions, Vectors& normals) {
  Upward(points, positions, normals, [=](size_t i, Draws&) {
    return std::array{std::exp2(-40.0 * static_cast<double>(i) / points), 0.0, 0.0};
  });
}

void PlaneGrid(size_t points, Vectors& positions, Vectors& normals) {
  const auto side = static_cast<size_t>(std::ceil(std::sqrt(static_cast<double>(points))));
  Upward(points, positions, normals, [=](size_t i, Draws&) {
    return std::array{static_cast<double>(i % side), static_cast<double>(i / side), 0.0};
  });
}

void SpaceGrid(size_t points, Vectors& positions, Vectors& normals) {
  const auto side = static_cast<size_t>(std::ceil(std::cbrt(static_cast<double>(points))));
  Upward(points, positions, normals, [=](size_t i, Draws&) {
    return std::array{static_cast<double>(i % side), static_cast<double>(i / side % side),
                      static_cast<double>(i / side / side)};
  });
}

void OnCircle(size_t points, Vectors& positions, Vectors& normals) {
  Upward(points, positions, normals, [](size_t, Draws& draws) {
    const double angle = 2.0 * std::numbers::pi * draws.Next();
    return std::array{std::cos(angle), std::sin(angle), 0.0};
  });
}

// From the points near the center, too few for a neighborhood, all others are equally far.
void SphereAroundCenter(size_t points, Vectors& positions, Vectors& normals) {
  OnSpheres(points, positions, normals, [](size_t i) { return i < 40 ? 1e-6 : 1.0; });
}

void SpheresAroundCenter(size_t points, Vectors& positions, Vectors& normals) {
  OnSpheres(points, positions, normals, [](size_t i) { return static_cast<double>(i % 10); });
}

void FewPlaces(size_t points, Vectors& positions, Vectors& normals) {
  OnSpheres(100, positions, normals, [](size_t) { return 1.0; });
  for (size_t i = positions.size(); i < points; ++i) {
    positions.push_back(positions[i % 100]);
    normals.push_back(normals[i % 100]);
  }
  positions.resize(points);
  normals.resize(points);
}

void EachPointTenTimes(size_t points, Vectors& positions, Vectors& normals) {
  OnSpheres((points + 9) / 10, positions, normals, [](size_t) { return 1.0; });
  for (size_t i = positions.size(), places = i; i < points; ++i) {
    positions.push_back(positions[i % places]);
    normals.push_back(normals[i % places]);
  }
}

constexpr HostileCloud kClouds[] = {
    {"all equal", AllEqual},
    {"half at zero", HalfAtZero},
    {"outlier at 5e20", OutlierAt5e20},
    {"outlier at 1e30", OutlierAt1e30},
    {"1e-20 wide beside 1", TinyBesideUnit},
    {"every magnitude", EveryMagnitude},
    {"two far clusters", TwoFarClusters},
    {"dense in sparse", DenseInSparse},
    {"line", OnLine},
    {"geometric spacing", GeometricSpacing},
    {"plane grid", PlaneGrid},
    {"space grid", SpaceGrid},
    {"circle", OnCircle},
    {"sphere around center", SphereAroundCenter},
    {"spheres around center", SpheresAroundCenter},
    {"few places", FewPlaces},
    {"each point ten times", EachPointTenTimes},
};

}  // namespace

std::span<const HostileCloud> HostileClouds() { return kClouds; }

std::string IdentifierOf(const HostileCloud& cloud) {
  std::string name(cloud.name);
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
}

}  // namespace curvd::testing
