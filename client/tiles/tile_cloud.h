// What is sent of a plan for some of its points: they, and the points around that their estimates look at.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/tiles/tile_plan.h"
#include "client/tiles/tile_point.h"

namespace curv {

// The points of a plan, on disk. Thread-safe.
class PointStore {
 public:
  // FAILED_PRECONDITION if the store cannot be read. REQUIRES: the plan outlives the store.
  static absl::StatusOr<PointStore> Open(const TilePlan& plan);

  const TilePlan& plan() const { return plan_; }
  // For each node of the plan's tree, the radius that neighborhoods are expected to have there, times the reach of
  // their estimates: that of a disc with as many points, where the smallest part around that has twice as many were
  // everywhere as dense; with a radius, that one.
  const std::vector<double>& expected_radii() const { return expected_radii_; }

  // Appends the points `first` to `first + count` of the store.
  absl::Status Append(uint64_t first, uint64_t count, std::vector<TilePoint>& points) const;

 private:
  PointStore(const TilePlan& plan, InputFile file);
  void ExpectRadius(int32_t node, double radius);

  const TilePlan& plan_;
  InputFile file_;
  std::vector<double> expected_radii_;
};

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

// How much of a cell went along as halo.
struct CellShare {
  int32_t cell = 0;
  double width = 0.0;     // those points whose distance from the tile's box is less
  bool is_whole = false;  // which are all
};

// A tile with its halo, and what is left out around it.
struct TileWithHalo {
  TileCloud cloud;
  Box box;                        // around the tile's own points
  std::vector<CellShare> shares;  // of other tiles' cells, ascending; of those that are not here nothing went along
};

// Reads a tile with a halo. A point of another tile goes along if it is nearer to the tile's box than `factor` times
// the radius that neighborhoods are expected to have there, judged by how dense the cells are on both sides. With
// factor 0 there is no halo. Errors are those of the store.
absl::StatusOr<TileWithHalo> ReadTile(const PointStore& store, size_t tile, double factor);

// Returns whether no point that was left out is nearer to `p`, a point of the tile, than `distance`, or as near. Then
// whatever looks that far, and no farther, gives for `p` what it gives in the whole cloud.
bool HasAllWithin(const TilePlan& plan, size_t tile, const TileWithHalo& read, const Position& p, double distance);

// A point, and how far around it all points are to go along.
struct Ball {
  TilePoint point;
  double distance = 0.0;  // may be infinite
};

// The box around balls.
Box BoxAround(std::span<const Ball> balls);
// How many points there are in the cells that balls touch, which ReadBalls reads.
uint64_t CountBalls(const TilePlan& plan, std::span<const Ball> balls);
// Reads all points in balls, and those of the same cells in the box around them; the queries are the balls' points.
// Errors are those of the store.
absl::StatusOr<TileCloud> ReadBalls(const PointStore& store, std::span<const Ball> balls);

}  // namespace curv
