// `curv estimate --tiles`: a file that is larger than a server takes, with the bytes that it has in one piece.
#pragma once

#include "client/cli/command.h"
#include "client/cli/files/estimate_files.h"

namespace curv {

// Throws CLI::ValidationError naming a flag that an estimate in tiles cannot serve. REQUIRES: flags.tiles.
void CheckEstimateInTiles(const EstimateFlags& flags);

// Plans, runs and merges in flags.tiles_directory (empty: the output's name with ".tiles"), and removes it. Where it
// ends early, the directory stays, and the next call with the same file and options goes on. Prints summary and errors,
// and returns how it ended. REQUIRES: CheckEstimateInTiles passed.
ExitCode EstimateInTiles(const EstimateFlags& flags);

}  // namespace curv
