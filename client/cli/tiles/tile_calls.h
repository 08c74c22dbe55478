// Sends tiles to a server.
#pragma once

#include <stop_token>

#include "client/cli/connection.h"
#include "client/curvature_client.h"
#include "client/tiles/tile_work.h"

namespace curv {

// Returns an estimator that calls a server, with those options. Its errors say so (IsServerError). REQUIRES: connection
// and stop outlive it.
TileEstimator EstimatorOn(const Connection& connection, const EstimateOptions& options, const std::stop_token& stop);

// Whether a server gave the error, or the way to it, rather than a file.
bool IsServerError(const absl::Status& status);

}  // namespace curv
