// Does the tiles of a plan that are not done.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>

#include "absl/status/statusor.h"
#include "client/tiles/tile_plan.h"
#include "client/tiles/tile_work.h"

namespace curv {

struct RunRequest {
  std::optional<size_t> tile;  // this one alone
  double halo_factor = kHaloFactor;
  int jobs = 2;  // tiles at a time: while one is estimated, another is read or written
};

struct RunProgress {
  uint64_t tiles = 0;  // that are to be done, and how many of them are
  uint64_t tiles_done = 0;
  uint64_t points = 0;
  uint64_t points_done = 0;
};

// What a run has done itself.
struct RunOutcome {
  uint64_t tiles = 0;
  uint64_t points = 0;
  uint64_t halo_points = 0;
  uint64_t uncertain_points = 0;
  uint64_t repair_points = 0;
  uint64_t coarse_points = 0;
  uint64_t opposed_tiles = 0;      // with normals to both sides of one surface
  uint64_t off_surface_tiles = 0;  // with normals that do not fit the positions
};

// Estimates the tiles without a result, one after the other, each by one of `jobs` threads; waits for those that other
// runs have at hand, and does them if these end. `progress` is called by one thread at a time. After an error, or a
// stop, the tiles at hand are ended or dropped, and no others begun: what is done stays. Errors are those of
// EstimateTile; CANCELLED after a stop; NOT_FOUND if there is no such tile.
absl::StatusOr<RunOutcome> RunTiles(const TilePlan& plan, const RunRequest& request, const TileEstimator& estimator,
                                    const std::stop_token& stop,
                                    const std::function<void(const RunProgress& progress)>& progress);

}  // namespace curv
