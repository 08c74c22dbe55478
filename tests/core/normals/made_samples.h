// Samples whose outcomes are known, for tests of what is made of them.
#pragma once

#include <cstddef>
#include <functional>

#include "core/index/spatial_index.h"
#include "core/normals/sample_table.h"

namespace curvd::testing {

// The number of neighbors of the candidates below: 12, and two steps to twice as many, up to 192.
inline constexpr size_t kMadeCandidates = 9;

// The index of a torus whose positions lie on no lattice, and are no copies.
SpatialIndex SampledIndex();

// Jets of degree 2 of a plane at 128 groups, whose normals are all along z. Their residuals are those of noise whose
// standard deviation `sigma` tells for each group. Neighbors fill discs, of a radius of 0.01 for one and twice that for
// four.
SampleTable PlaneSample(const SpatialIndex& index, const std::function<double(size_t group)>& sigma);

}  // namespace curvd::testing
