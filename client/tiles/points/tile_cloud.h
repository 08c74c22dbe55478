// What is sent of a plan for some of its points: they, and the points around that their estimates look at.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "client/tiles/points/point_store.h"
#include "client/tiles/tile_plan.h"
#include "client/tiles/tile_point.h"

namespace curv {

// Positions and normals as they are sent, x y z of each.
struct FloatArrays {
  std::vector<float> positions;  // of doubles: relative to an origin on the lattice, and exact
  std::vector<float> normals;
  std::vector<uint64_t> ids;  // ascending
  double spacing = 0.0;       // of the lattice that the positions are on; 0: floats as they are
  // Steps between positions where the cloud is so long that they are not exact on the plan's lattice; else 0.
  double coarse_spacing = 0.0;
};

struct TileCloud {
  std::vector<TilePoint> points;  // ascending by id, so that ties are decided as in the whole cloud
  std::vector<uint32_t> queries;  // which of the points get results; ascending
};

// Whether a box is short enough for the positions in it to be on the lattice of the plan.
bool FitsFloats(const TilePlan& plan, const Box& box);
FloatArrays ToFloats(const TilePlan& plan, const TileCloud& cloud);

// A point, and how far around it all points are to go along.
struct Ball {
  TilePoint point;
  double distance = 0.0;  // may be infinite
};

// The box around balls.
Box BoxAround(std::span<const Ball> balls);
// How many points there are in the cells that balls touch, which ReadBalls reads.
uint64_t CountBalls(const TilePlan& plan, std::span<const Ball> balls);
// Reads all points in balls, and perhaps others in the box around them; the queries are the balls' points. Errors are
// those of the store.
absl::StatusOr<TileCloud> ReadBalls(const PointStore& store, std::span<const Ball> balls);

}  // namespace curv
