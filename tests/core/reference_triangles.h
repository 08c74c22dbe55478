// Triangles over chosen points of a neighborhood in plain doubles: the oracle for the random strategies.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/estimators/options.h"
#include "tests/core/reference_measures.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {

// Corners by id.
using IdTriangle = std::array<int, 3>;

// What `triangles` say of the curvature at point i, whose neighborhood is `ids`.
ReferenceCurvature ReferenceTriangles(const TestPoints& points, size_t i, const std::vector<int>& ids,
                                      std::span<const IdTriangle> triangles, const EstimatorOptions& options);

// Every triangle that has its corners among `ids`.
std::vector<IdTriangle> AllTriangles(const std::vector<int>& ids);

}  // namespace curvd::testing
