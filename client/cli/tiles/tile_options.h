// The options of an estimate that is done in tiles, as a plan keeps them.
#pragma once

#include <nlohmann/json.hpp>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/curvature_client.h"
#include "client/tiles/tile_plan.h"

namespace curv {

// How far around a point its estimate looks. INVALID_ARGUMENT naming the flag for estimates that look at more than the
// points around, so that tiles would change them: scales that the cloud chooses, Delaunay's
// without a bound.
absl::StatusOr<TileReach> ReachOf(const EstimateOptions& options);

// What results depend on. A server that is asked with what OptionsOf returns gives the same results.
nlohmann::ordered_json JsonOf(const EstimateOptions& options);
// FAILED_PRECONDITION if the JSON is not that of JsonOf, or this program is too old for it.
absl::StatusOr<EstimateOptions> OptionsOf(const nlohmann::ordered_json& json);

}  // namespace curv
