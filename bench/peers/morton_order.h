// Points in the order of a space-filling curve.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace curvd::bench {

// The indices of packed triples along a Morton curve of 1024 cells an axis; sorted by radix.
std::vector<uint32_t> MortonOrder(std::span<const float> positions);

}  // namespace curvd::bench
