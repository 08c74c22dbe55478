// Finds the nearest neighbors of every position of a cloud, on all cores.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/functional/function_ref.h"
#include "client/surfaces/vec3.h"

namespace curv {

struct Neighbor {
  uint32_t index;
  double squared_distance;
};

// The largest number of neighbors that can be asked for.
inline constexpr int kMaxNeighbors = 32;

// Called with the index of a position and its neighbors, which are valid during the call only.
using NeighborVisitor = absl::FunctionRef<void(uint32_t, std::span<const Neighbor>)>;

// Calls visit(i, neighbors) once for each position i with its `count` nearest other positions, or with all others if
// there are fewer. Neighbors come in ascending order of distance, equally distant ones in ascending order of their
// index. Distances are the squares that Dot computes. Where more than `count` others lie at the very place of a
// position, any `count` of them are its neighbors; which ones depends on the positions only.
//
// Uses `threads` threads, or one for each core if `threads` is 0. `visit` is called from several of them at once, for
// different positions, in no particular order.
//
// REQUIRES: positions are finite, fewer than 2^32; count in [1, kMaxNeighbors]; threads >= 0.
void ForEachNeighborhood(const std::vector<Vec3>& positions, int count, int threads, NeighborVisitor visit);

}  // namespace curv
