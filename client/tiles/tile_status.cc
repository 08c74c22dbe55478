#include "client/tiles/tile_status.h"

#include <algorithm>
#include <limits>

#include "client/tiles/tile_claim.h"

namespace curv {

TileStatus StatusOf(const TilePlan& plan) {
  TileStatus status;
  status.tiles = plan.tiles.size();
  status.points = plan.tree.root().count;
  double begin = std::numeric_limits<double>::infinity(), end = 0.0;
  for (size_t tile = 0; tile < plan.tiles.size(); ++tile) {
    const absl::StatusOr<TileResult> result = ReadTileResult(plan, tile);
    if (!result.ok()) {
      status.tiles_left.push_back(tile);
      if (!absl::IsNotFound(result.status())) ++status.tiles_damaged;
      if (TileClaim::IsHeld(plan, tile)) ++status.tiles_running;
      continue;
    }
    ++status.tiles_done;
    status.points_done += result->points;
    status.halo_points += result->halo_points;
    status.uncertain_points += result->uncertain_points;
    status.repair_points += result->repair_points;
    status.coarse_points += result->coarse_points;
    status.opposed_tiles += result->has_opposed_normals ? 1 : 0;
    status.off_surface_tiles += result->has_normals_off_surface ? 1 : 0;
    status.work_seconds += result->seconds;
    begin = std::min(begin, result->finished - result->seconds);
    end = std::max(end, result->finished);
  }
  if (end > begin) status.points_per_second = static_cast<double>(status.points_done) / (end - begin);
  if (status.points_per_second > 0.0 && status.tiles_running > 0) {
    status.seconds_left = static_cast<double>(status.points - status.points_done) / status.points_per_second;
  }
  return status;
}

std::vector<TileFault> VerifyTiles(const TilePlan& plan) {
  std::vector<TileFault> faults;
  for (size_t tile = 0; tile < plan.tiles.size(); ++tile) {
    const absl::StatusOr<TileResult> result = ReadTileResult(plan, tile);
    absl::Status status = result.status();
    if (status.ok()) status = ReadTileRows(plan, *result, [](std::string_view) { return absl::OkStatus(); });
    if (!status.ok()) faults.push_back({tile, status});
  }
  return faults;
}

}  // namespace curv
