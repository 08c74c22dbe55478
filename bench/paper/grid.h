// What the error figures need: which clouds, under which noise, with how many neighbors.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/paper/samples.h"

namespace curvd::bench {

struct Noise {
  double position;
  double normal;
};

// One cloud, or one realization of a noisy one, and the neighbor counts to estimate it with.
struct GridCloud {
  std::string surface;
  std::string sampling;
  size_t points;  // as asked for
  Noise noise;
  uint64_t realization;  // from 1; the seed of sampling and noise
  std::function<Samples()> undisturbed;
  std::vector<uint32_t> neighbor_counts;
};

// How much is made.
enum class GridSize {
  kTiny,   // seconds: shows that the harness works
  kQuick,  // minutes: the figures' shape
  kWhole,  // the paper's figures
};

// Even samples of goursat and torus under all noise, the non-uniform ones, and the paper's own clouds of those in
// `paper_folder` that exist.
std::vector<GridCloud> PaperGrid(GridSize size, const std::string& paper_folder);

}  // namespace curvd::bench
