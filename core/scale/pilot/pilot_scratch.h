// What one thread estimates the neighborhoods of sampled points with.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/estimators/neighbors/collect.h"
#include "core/scale/pilot/pilot_batch.h"
#include "core/scale/pilot/pilot_table.h"
#include "core/scale/point_fits/neighbor_normal.h"

namespace curvd {

struct PilotScratch : CollectScratch {
  // Neighbors at the radius of a neighborhood; more, which are hardly ever there, are left out.
  static constexpr size_t kMostAtRim = 64;

  std::vector<uint32_t> order;             // of the neighbors, by distance
  std::vector<float> squared;              // distances of the neighbors
  std::vector<uint64_t> keys, other_keys;  // what they are sorted by
  std::vector<uint32_t> tied;              // neighbors that are equally far away
  std::vector<NeighborNormal> normals;
  std::array<std::vector<PilotNeighbor>, PilotPoint::kParts> rims;  // neighbors at a radius, of all and of each half

  size_t bytes() const override;
  static size_t MostBytes(const EstimatorOptions& options, size_t point_count);
};

}  // namespace curvd
