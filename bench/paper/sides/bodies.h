// Thin bodies made of flat and round parts.
#pragma once

#include <cstddef>
#include <vector>

#include "bench/paper/sides/patches.h"

namespace curvd::bench {

// Bodies that are `thickness` spacings thin somewhere if they have so many points.
std::vector<Patch> Bodies(size_t points, double thickness);

}  // namespace curvd::bench
