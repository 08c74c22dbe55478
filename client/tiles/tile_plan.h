// What `curv tiles plan` decided: which points there are, where they lie, and how they are to be estimated.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/io/blocks/input_file.h"
#include "client/tiles/cell_tree.h"

namespace curv {

struct TileInput {
  std::string path;    // absolute
  std::string format;  // of --format; empty: the name tells
  uint64_t points = 0;
  FileStamp stamp;  // when it was planned
};

// How far around a point its estimate looks.
struct TileReach {
  uint32_t neighbor_count = 0;  // of the neighborhoods; 0: they have a radius
  double radius = 0.0;          // of the neighborhoods, else 0
  double factor = 1.0;          // an estimate looks at most this times the neighborhood's radius around its point

  // How far it looks where the neighborhood has this radius. Radii come as floats, and are off by a last digit.
  double Around(double neighborhood_radius) const { return factor * neighborhood_radius * (1.0 + 1e-6); }
};

// A plan in a directory:
//   plan.json   this, written last
//   cells.bin   the tree of cells
//   points.bin  the points in the order of the cells, within a cell in that of the input
//   results/    a file for each tile that is done
//   locks/      a file for each tile that somebody has begun
struct TilePlan {
  std::string directory;
  std::string id;  // 16 hexadecimal digits, others for each plan
  std::vector<TileInput> inputs;
  uint64_t points = 0;    // of all inputs
  uint64_t unusable = 0;  // of them those that are in no tile: not finite, or with a normal without a direction
  bool is_double = false;
  double spacing = 0.0;  // of the lattice of doubles; 0 with floats
  uint64_t memory_bytes = 0;
  uint64_t tile_points = 0;
  TileReach reach;
  nlohmann::ordered_json options;    // of the estimate, as the command has them
  std::vector<std::string> columns;  // of the inputs, which go into the result: "x float32"
  CellTree tree;
  std::vector<int32_t> tiles;  // their nodes in the tree

  const CellNode& tile(size_t number) const { return tree.nodes()[static_cast<size_t>(tiles[number])]; }
  std::string PathOf(const std::string& name) const { return directory + "/" + name; }
};

// Writes plan.json and cells.bin, whole or not at all. DATA_LOSS naming the file and the system's reason.
absl::Status SavePlan(const TilePlan& plan);

// Reads the plan of a directory. FAILED_PRECONDITION saying what is wrong: there is none, it was made by a version with
// another format, or a file is damaged or lacks.
absl::StatusOr<TilePlan> LoadPlan(const std::string& directory);

// Removes a plan with its results, and the directory unless it holds anything else. REQUIRES: nobody works on it.
// DATA_LOSS naming what cannot be removed, and the system's reason.
absl::Status RemovePlan(const TilePlan& plan);

}  // namespace curv
