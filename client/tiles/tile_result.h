// The results of tiles in a plan's directory: one file for each tile that is done, which makes them its journal.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/io/point_table.h"
#include "client/tiles/tile_plan.h"

namespace curv {

// What a file of results says of itself: its first line, in JSON. Rows follow: the point's id in 8 bytes, then a scalar
// for each column, ascending by id.
struct TileResult {
  size_t tile = 0;
  uint64_t points = 0;
  std::vector<std::pair<std::string, ScalarKind>> columns;
  uint32_t crc32 = 0;    // of the rows
  uint64_t rows_at = 0;  // byte of the first row

  uint64_t halo_points = 0;       // that went along with the tile
  uint64_t uncertain_points = 0;  // whose neighborhoods might have reached beyond the halo
  uint64_t repair_points = 0;     // that were sent to estimate these again
  uint64_t coarse_points = 0;     // whose surroundings are so long that the plan's lattice is too fine for them
  bool has_opposed_normals = false;
  bool has_normals_off_surface = false;
  double seconds = 0.0;   // of work
  double finished = 0.0;  // seconds since 1970

  size_t row_bytes() const;
};

// Writes the results of a tile, safely on disk, whole or not at all; those that are there are replaced. DATA_LOSS
// naming the file and the system's reason. REQUIRES: as many ids, ascending, as rows in each column, and `points`. What
// `result` says of columns, checksum and rows is not used.
absl::Status WriteTileResult(const TilePlan& plan, TileResult result, const std::vector<uint64_t>& ids,
                             const std::vector<Column>& columns);

// Returns what a tile's file says; its rows are not read. NOT_FOUND if there is none. FAILED_PRECONDITION naming the
// file and what is wrong if it is of another plan, or too short or long.
absl::StatusOr<TileResult> ReadTileResult(const TilePlan& plan, size_t tile);

// Hands out the rows, whole ones at a time, and compares their checksum at the end. FAILED_PRECONDITION naming the file
// if it cannot be read or has another; errors of `take`.
absl::Status ReadTileRows(const TilePlan& plan, const TileResult& result,
                          const std::function<absl::Status(std::string_view rows)>& take);

}  // namespace curv
