// Heights that are wrong in common, as those of scans that are warped, denoised or rounded, and of such as err more
// with the distance: errors that neighbors share, which no independent noise shows.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>

#include "bench/paper/samples.h"

namespace curvd::bench {

enum class HeightErrorKind {
  kNone,
  kWaves,   // the mean of sines along x, y and z, as of a warped scan
  kClumps,  // noise that is averaged with Gaussian weights, as of a denoised scan
  kSteps,   // z is rounded to multiples of the size, as of depths in whole units
  kGrowth,  // independent noise whose standard deviation grows along x from 0 to the size
};

// Lengths are in spacings: the square root of the area per point, in the median of the points.
struct HeightFlags {
  HeightErrorKind kind = HeightErrorKind::kNone;
  double size = 0.1;     // amplitude of waves, standard deviation of clumps and growth, distance of steps
  double length = 20.0;  // of waves, or standard deviation of the weights of clumps
};

// REQUIRES: `flags` outlives the parse.
void AddHeightFlags(CLI::App& app, HeightFlags& flags);

// The same samples, moved along their normals, or for steps along z. Normals and truth stay.
Samples WithHeightErrors(const Samples& samples, const HeightFlags& flags, uint64_t seed);

}  // namespace curvd::bench
