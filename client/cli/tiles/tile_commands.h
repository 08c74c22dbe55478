// The subcommands of `curv tiles`.
#pragma once

#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "client/cli/command.h"
#include "client/tiles/tile_plan.h"

namespace curv {

// Each adds one to `tiles`; see AddEstimate.
void AddTilesPlan(CLI::App& tiles, Action& action);
void AddTilesRun(CLI::App& tiles, Action& action);
void AddTilesStatus(CLI::App& tiles, Action& action);
void AddTilesMerge(CLI::App& tiles, Action& action);
void AddTilesVerify(CLI::App& tiles, Action& action);

// Adds the argument that names a plan's directory.
void AddPlanDirectory(CLI::App& command, std::string& directory);

// Prints an error of client/tiles, or of a server that was called for a tile, and returns the code that follows.
ExitCode FailTiles(const absl::Status& status);

}  // namespace curv
