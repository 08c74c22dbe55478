// Divides clouds that may be larger than memory into tiles.
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/tiles/tile_plan.h"

namespace curv {

struct PlanRequest {
  std::vector<std::string> inputs;
  std::string format;     // of inputs whose names do not tell theirs
  std::string directory;  // made if it is not there
  uint64_t tile_points = 350'000;
  uint64_t memory_bytes = uint64_t{1} << 30;
  bool skip_invalid = false;  // whether points that are not finite get a status, instead of being refused
  double spacing = 0.0;       // of the lattice of doubles, a power of two; 0: LatticeSpacing
  TileReach reach;
  nlohmann::ordered_json options;
};

// What a plan is about, for the user.
struct PlanProgress {
  const char* step = "";  // "reading", "sorting", "writing"
  uint64_t done = 0;      // points
  uint64_t of = 0;        // points; 0: not known yet
};

struct PlanOutcome {
  TilePlan plan;
  std::vector<std::string> notes;  // what the user should know
};

// Reads the inputs twice and writes each point twice, in bounded memory, whatever the distribution of the points: some
// may coincide, lie very dense, or far away. A tile has about `tile_points`, or more where so many lie at one place.
// `progress` is called now and then. Errors:
// - INVALID_ARGUMENT: an input cannot be read, is no cloud with normals, or has a point that is not finite or a normal
//   without a direction, unless these are skipped; a result would not fit its inputs
// - RESOURCE_EXHAUSTED: an input would have to be read as a whole, and is too large for that
// - ALREADY_EXISTS: the directory has a plan
// - DATA_LOSS: something cannot be written; what was written is of no use, and is replaced by the next plan
// - CANCELLED: `stop` was requested
absl::StatusOr<PlanOutcome> PlanTiles(const PlanRequest& request, const std::stop_token& stop,
                                      const std::function<void(const PlanProgress& progress)>& progress);

}  // namespace curv
