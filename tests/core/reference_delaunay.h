// Umbrellas and CNC-Delaunay by brute force in doubles: the oracle for core/estimators/delaunay/umbrella.h and its
// kernels. Written from the definition (a triangle is Delaunay if its circle is empty); shares nothing with
// core/kernels.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/estimators/options.h"
#include "tests/core/reference_measures.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {

struct ReferenceUmbrella {
  // The other two corners of each triangle, by id, counterclockwise seen against the point's normal.
  std::vector<std::array<int, 2>> triangles;
  // No decision behind it is so near a tie that rounding may decide it either way. Exact ties are decided by rule.
  bool certain = true;
};

ReferenceUmbrella BruteForceUmbrella(const TestPoints& points, size_t i);

// Curvature at point i from the umbrellas of all points. The margin is 0 if one near it is uncertain.
ReferenceCurvature ReferenceDelaunay(const TestPoints& points, const std::vector<ReferenceUmbrella>& umbrellas,
                                     size_t i, const EstimatorOptions& options);

}  // namespace curvd::testing
