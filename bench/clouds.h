// The clouds that the benchmarks run on.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/cloud/cloud.h"

namespace curvd::bench {

// Packed arrays, points in random order.
struct BenchCloud {
  std::string name;
  std::vector<float> positions;  // x y z
  std::vector<float> normals;    // unit, outward
  std::vector<float> true_mean;  // exact mean curvature of each point; empty if nobody knows it

  size_t size() const { return positions.size() / 3; }
};

// `points` points, evenly spread over "torus" (R = 6, r = 2) or "goursat"; always the same. Kept in `folder`, since
// making ten million takes minutes. Ends the program on failure.
BenchCloud SurfaceCloud(const std::string& surface, size_t points, const std::string& folder);

// The scan of the armadillo with 100,000 points, in random order, its normals turned to one side (5 % of them are not
// in the file); nothing if it is not on this machine.
std::optional<BenchCloud> ArmadilloCloud();

// The same points as the core takes them.
Cloud ToCloud(const BenchCloud& cloud);

}  // namespace curvd::bench
