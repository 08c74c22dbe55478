#include "client/cli/tiles/tile_steps.h"

#include <malloc.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/cli/command.h"
#include "client/cli/numbers.h"
#include "client/cli/result_columns.h"
#include "client/cli/tiles/tile_calls.h"
#include "client/cli/tiles/tiles_bar.h"
#include "client/tiles/merge_tiles.h"

namespace curv {
namespace {

// Has the allocator keep what is freed, for all threads together, instead of giving it back to the system: tiles take
// and free the same large arrays again and again, and pages that come from the system are filled with zeros each time.
void KeepFreedMemory() {
#ifdef __GLIBC__
  constexpr int kLargest = 1 << 30;
  mallopt(M_ARENA_MAX, 1);
  mallopt(M_MMAP_THRESHOLD, kLargest);
  mallopt(M_TRIM_THRESHOLD, kLargest);
#endif
}

}  // namespace

absl::StatusOr<PlanOutcome> PlanWithProgress(const PlanRequest& request, const std::stop_token& stop) {
  KeepFreedMemory();
  TilesBar bar;
  return PlanTiles(request, stop,
                   [&bar](const PlanProgress& progress) { bar.Show(progress.step, progress.done, progress.of); });
}

absl::StatusOr<RunOutcome> RunWithProgress(const TilePlan& plan, const RunRequest& request,
                                           const Connection& connection, const EstimateOptions& options,
                                           const std::stop_token& stop) {
  KeepFreedMemory();
  const TileEstimator estimator = EstimatorOn(connection, options, plan.reach.factor, stop);
  absl::StatusOr<RunOutcome> outcome;
  {
    TilesBar bar;
    outcome = RunTiles(plan, request, estimator, stop, [&bar](const RunProgress& progress) {
      bar.Show("estimating", progress.points_done, progress.points,
               absl::StrCat(", ", progress.tiles_done, " of ", progress.tiles, " tiles"));
    });
  }
  if (outcome.ok() && outcome->opposed_tiles > 0) {
    PrintWarning(absl::StrCat("in ", CountOf(outcome->opposed_tiles, "tile"),
                              " some normals point to opposite sides of one surface. Which points lose their "
                              "results there was decided tile by tile: run curv orient before"));
  }
  if (outcome.ok() && outcome->off_surface_tiles > 0) {
    PrintWarning(absl::StrCat("in ", CountOf(outcome->off_surface_tiles, "tile"),
                              " the normals do not fit the positions, so that curvature means little there: run curv "
                              "normals before"));
  }
  return outcome;
}

absl::StatusOr<StatusCounts> MergeWithProgress(const TilePlan& plan, const std::string& output, const SaveOptions& save,
                                               const std::stop_token& stop) {
  std::vector<std::string> names;
  for (const std::string& column : plan.columns) names.push_back(column.substr(0, column.rfind(' ')));
  if (const std::string dropped = NoteOnDroppedColumns(names); !dropped.empty()) PrintNote(dropped);
  TilesBar bar;
  return MergeTiles(plan, output, save, JoinResults, stop,
                    [&](uint64_t points) { bar.Show("merging", points, plan.points); });
}

}  // namespace curv
