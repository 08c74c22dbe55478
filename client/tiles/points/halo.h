// A tile with the points around it that its estimates look at, and which of them that is certain for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "client/tiles/box.h"
#include "client/tiles/points/point_store.h"
#include "client/tiles/points/tile_cloud.h"

namespace curv {

// A cell of the tile, with the halo around it.
struct OwnCell {
  int32_t cell = 0;
  double width = 0.0;  // no point of another tile that was left out is nearer to one of the cell's points
};

// A cell of another tile that was read.
struct ReadCell {
  int32_t cell = 0;
  std::vector<Position> left_out;  // those of its points that did not go along
};

struct TileWithHalo {
  TileCloud cloud;
  std::vector<OwnCell> own;     // ascending by cell
  std::vector<uint32_t> cells;  // for each query, the place of its cell in `own`
  std::vector<ReadCell> read;   // ascending by cell; of other tiles' cells that are not here nothing went along
};

// Reads a tile with a halo. A point of another tile goes along if it is nearer to a point of one of the tile's cells,
// or to a box around a few of them, than `factor` times the radius that neighborhoods have there times their reach, as
// a few points of the cell show. Neighborhoods with a given radius look no farther than that, and neither do their
// halos. With factor 0 there is no halo. Errors are those of the store.
absl::StatusOr<TileWithHalo> ReadTile(const PointStore& store, size_t tile, double factor);

// Returns whether no point that was left out is nearer to the point of a query than `distance`, or as near. Then
// whatever looks that far, and no farther, gives for it what it gives in the whole cloud. REQUIRES: `tile` was read by
// ReadTile, query < tile.cells.size().
bool HasAllWithin(const TilePlan& plan, const TileWithHalo& tile, size_t query, double distance);

}  // namespace curv
