// The steps of an estimate in tiles, each with its progress on a terminal.
#pragma once

#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "client/cli/connection.h"
#include "client/curvature_client.h"
#include "client/io/status_counts.h"
#include "client/io/table_file.h"
#include "client/tiles/plan_tiles.h"
#include "client/tiles/run_tiles.h"

namespace curv {

// PlanTiles.
absl::StatusOr<PlanOutcome> PlanWithProgress(const PlanRequest& request, const std::stop_token& stop);
// RunTiles, on the server of a connection, and warns of what tiles decide by themselves. `options` are those of the
// plan and what a call takes beside them.
absl::StatusOr<RunOutcome> RunWithProgress(const TilePlan& plan, const RunRequest& request,
                                           const Connection& connection, const EstimateOptions& options,
                                           const std::stop_token& stop);
// MergeTiles, which notes the columns of the inputs that are left out.
absl::StatusOr<StatusCounts> MergeWithProgress(const TilePlan& plan, const std::string& output, const SaveOptions& save,
                                               const std::stop_token& stop);

}  // namespace curv
