// Thin closed plates.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "bench/paper/sides/shape.h"

namespace curvd::bench {

enum class Sampling { kShaken, kRandom, kLattice };

// A plate of about so many points, its narrow sides included. Its outline is a square, strip, bracket, triangle, star
// or disk.
Shape Plate(const std::string& outline, size_t points, double thickness, Sampling sampling, uint64_t seed);

}  // namespace curvd::bench
