// Clouds for the probes that tell what given normals were made by, and how these are run.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/normals/normal_fit.h"
#include "tests/core/normals/normal_clouds.h"
#include "tests/core/sanitized.h"

namespace curvd::testing {

// The fit whose halves tell noise, of what the probe finds in a cloud's own normals; the blocks run in order, or the
// last ones first.
template <typename Probe>
std::optional<NormalFit> Probed(const TestPoints& points, uint32_t max_neighbor_count, bool backwards) {
  const SpatialIndex index = BuildIndex(points.ToCloud());
  Probe probe(index, max_neighbor_count, 1);
  const std::atomic<bool> stopped = false;
  while (probe.AddBlocks()) {
    const size_t count = probe.block_count();
    for (size_t i = 0; i < count; ++i) {
      EXPECT_TRUE(probe.RunBlock(backwards ? count - 1 - i : i, 0, stopped).ok());
    }
  }
  if (!probe.found().has_value() || !probe.found()->of_halves.has_value()) return std::nullopt;
  const NormalMethod of_halves = probe.found()->of_halves->method;
  EXPECT_TRUE(of_halves == probe.found()->made_by.method || of_halves == NormalMethod::kPca);
  return probe.found()->of_halves;
}

inline uint32_t ProbedCount(const NormalFit& fit) { return std::get<NeighborCount>(fit.neighborhood).count; }

// A torus of radii 6 and 2 of some thousand points; noise has that standard deviation.
TestPoints TorusWithNoise(double sigma);

// The points with normals that are made of their positions, on the sides that they had.
TestPoints WithFittedNormals(TestPoints points, const NormalOptions& how);
TestPoints WithFittedNormals(TestPoints points, NormalMethod method, uint32_t count);

struct ProbedCloud {
  std::string what;
  TestPoints points;
};
// Those whose normals were not made of the positions: exact ones, also where fits are turned by chance, or have the
// exact normals by symmetry, and ones with noise of their own.
std::vector<ProbedCloud> CloudsWithOtherNormals();

template <typename Probe>
void ExpectEndsWhereStopped() {
  const SpatialIndex index = BuildIndex(TorusWithNoise(0.05).ToCloud());
  Probe probe(index, 10'000, 1);
  const std::atomic<bool> stopped = true;
  ASSERT_TRUE(probe.AddBlocks());
  EXPECT_EQ(probe.RunBlock(0, 0, stopped).code(), absl::StatusCode::kCancelled);
}

}  // namespace curvd::testing
