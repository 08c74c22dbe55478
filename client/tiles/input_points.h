// Walks over the points of a plan's inputs.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/io/point_table.h"
#include "client/tiles/tile_plan.h"
#include "client/tiles/tile_point.h"

namespace curv {

// The points of one block, in the order of the file.
struct PointBlock {
  size_t input;             // which of the inputs
  uint64_t first_id;        // of the block's first point
  const PointTable* table;  // all columns
};

// "x float32": how a plan tells a column.
std::string ColumnText(const Column& column);

// How many bytes of an input are read at a time, and how many an input may have that is read as a whole.
struct ReadingBounds {
  uint64_t block_bytes;
  uint64_t most_bytes;

  // For a program that may use so much memory, of which reading takes a part.
  static ReadingBounds For(uint64_t memory_bytes);
};

// Calls visit for each block of the inputs, one after the other. Errors are those of reading (see TableBlocks) and of
// `visit`.
absl::Status ForEachBlock(const std::vector<TileInput>& inputs, const ReadingBounds& bounds,
                          const std::function<absl::Status(const PointBlock& block)>& visit);

// The same for inputs that were planned. FAILED_PRECONDITION if one has changed since.
absl::Status ForEachPlannedBlock(const TilePlan& plan, const ReadingBounds& bounds,
                                 const std::function<absl::Status(const PointBlock& block)>& visit);

// Position and normal of each point of a block, the position as the server would get it: in floats, or in doubles on no
// lattice yet. INVALID_ARGUMENT if the table lacks a coordinate or normals. Sets `is_double` if ExtractCloud takes
// doubles of it.
absl::Status ExtractPoints(const PointBlock& block, std::vector<TilePoint>& points, bool& is_double);

}  // namespace curv
