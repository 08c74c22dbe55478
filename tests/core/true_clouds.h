// Random samples of surfaces whose curvature is known at every point.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/estimators/curvature_field.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {

struct TruePoints {
  TestPoints points;
  std::vector<double> mean, gaussian;  // curvature

  void Add(const std::array<double, 3>& position, const std::array<double, 3>& normal, double k1, double k2);
};

// Mean errors over the points that have curvature.
struct MeanErrors {
  double mean = 0.0, gaussian = 0.0;
};
MeanErrors ErrorsOf(const TruePoints& truth, std::span<const PointCurvature> found);

// A torus of radii 3 and 1 around z, even over its area.
TruePoints TrueTorus(size_t points, uint64_t seed);

// A height field over a square of ten units a side, of waves of all lengths down to 5 / 6 of a unit.
TruePoints RoughTerrain(size_t points, uint64_t seed);

// A height field over a square with a point in each unit of area, at random, of waves in a dozen directions: their
// wavelength in units, and the root mean square of their slope.
TruePoints TexturedPlane(size_t points, double wavelength, double slope, uint64_t seed);

// A catenoid along z, as lines around it leave it: the next line is `gap` times as far as the next point of a line.
TruePoints ScannedCatenoid(size_t points, double gap, uint64_t seed);

}  // namespace curvd::testing
