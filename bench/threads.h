// What two threads gain over one, against what the machine gives at best.
#pragma once

#include <string>

#include "bench/side_by_side.h"
#include "bench/table.h"

namespace curvd::bench {

// Work that shares nothing, split between `threads`: figures "total" and "wall".
Figures Spin(int threads);

// The target that two threads gain 1.85 times; not measurable where the spinning threads of the same run gained less.
void AddSpeedup(const std::string& what, double speedup, double control, Targets& targets);

}  // namespace curvd::bench
