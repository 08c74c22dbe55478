// The lattice on which coordinates in double go to a server, the same one for every tile.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "client/tiles/box.h"

namespace curv {

// How many steps a coordinate may be from the origin (PositionLattice). Floats hold twice as many: there is room for
// what estimators add to positions.
inline constexpr double kMostSteps = 8'388'608.0;  // 2^23

// Returns the coordinate's nearest multiple of `spacing`, a power of two.
inline double OnLattice(double coordinate, double spacing) { return std::nearbyint(coordinate / spacing) * spacing; }

inline Position OnLattice(const Position& p, double spacing) {
  return {OnLattice(p[0], spacing), OnLattice(p[1], spacing), OnLattice(p[2], spacing)};
}

// The range of spacings that a server takes.
inline constexpr double kLeastSpacing = 0x1p-100;
inline constexpr double kMostSpacing = 0x1p100;

// Returns a spacing for a cloud of `points` points: the largest power of two that is at most 2^-12 of the distance
// between neighbors in places of middle density, so that a tile of half a million points is not too long even where
// points are a few times as far apart; not less than the last digit of the coordinates. `sample` are points of the
// cloud, drawn at random; the more, the better. Depends on nothing else, so that two plans of one cloud have one
// lattice. REQUIRES: the sample is not empty.
double LatticeSpacing(std::span<const Position> sample, uint64_t points);

// Returns the smallest spacing, `spacing` times a power of two, with which no coordinate of a box that long on its
// longest axis is more than kMostSteps from an origin in its middle.
double SpacingFor(double extent, double spacing);

}  // namespace curv
