// Samples a surface that is a map of the unit square.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bench/paper/sides/patches.h"
#include "bench/paper/sides/shape.h"

namespace curvd::bench {

// So many points, scaled to a spacing of 1 on average: at random; or none nearer to another one of its sheet than 0.7
// spacings.
Shape SampleOf(const Patch& patch, size_t points, uint64_t seed, bool is_apart = false);

}  // namespace curvd::bench
