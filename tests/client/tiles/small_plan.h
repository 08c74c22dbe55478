// A small plan in a directory of its own.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/tiles/tile_plan.h"

namespace curv::testing {

// A directory that is removed with all in it.
class ScratchDirectory {
 public:
  ScratchDirectory();
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  ~ScratchDirectory();

  std::string PathOf(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

// Plans hills whose density falls with the distance from a corner, into tiles of about `tile_points`, in
// scratch/plan. The cloud is scratch/cloud.ply; `options` are those of the estimate.
TilePlan PlanHills(const ScratchDirectory& scratch, size_t points, uint64_t tile_points, const TileReach& reach,
                   const nlohmann::ordered_json& options = nlohmann::ordered_json::object());

}  // namespace curv::testing
