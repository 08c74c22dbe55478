// Sends tiles to a server.
#pragma once

#include <stop_token>

#include "client/cli/connection.h"
#include "client/curvature_client.h"
#include "client/tiles/tile_work.h"

namespace curv {

// Returns an estimator that calls a server, with those options. Its errors say so (IsServerError); FAILED_PRECONDITION
// if the server's estimates look further around than `reach_factor` says, UNIMPLEMENTED if it knows no parts of clouds.
// REQUIRES: connection and stop outlive it.
TileEstimator EstimatorOn(const Connection& connection, const EstimateOptions& options, double reach_factor,
                          const std::stop_token& stop);

// Whether a server gave the error, or the way to it, rather than a file.
bool IsServerError(const absl::Status& status);

}  // namespace curv
