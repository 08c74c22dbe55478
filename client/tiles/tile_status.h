// Tells how far the tiles of a plan are.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/tiles/tile_plan.h"
#include "client/tiles/tile_result.h"

namespace curv {

struct TileStatus {
  uint64_t tiles = 0;
  uint64_t tiles_done = 0;
  std::vector<size_t> tiles_left;  // their numbers, ascending
  uint64_t tiles_running = 0;      // that somebody has at hand
  uint64_t tiles_damaged = 0;      // whose file is no result: they are done again
  uint64_t points = 0;             // in tiles
  uint64_t points_done = 0;
  // Sums over the tiles that are done; see TileResult.
  uint64_t halo_points = 0;
  uint64_t uncertain_points = 0;
  uint64_t repair_points = 0;
  uint64_t coarse_points = 0;
  uint64_t opposed_tiles = 0;
  uint64_t off_surface_tiles = 0;
  double work_seconds = 0.0;
  double points_per_second = 0.0;      // since the first tile was begun, up to the last that was done; 0: not known
  std::optional<double> seconds_left;  // if it goes on like that; nothing while nobody works

  bool is_complete() const { return tiles_done == tiles; }
};

TileStatus StatusOf(const TilePlan& plan);

// What is wrong with a file of results, or that it is not there.
struct TileFault {
  size_t tile = 0;
  absl::Status status;
};

// Reads all results, and compares them with their checksums. Tiles that are not done are NOT_FOUND.
std::vector<TileFault> VerifyTiles(const TilePlan& plan);

}  // namespace curv
