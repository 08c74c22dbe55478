// Makes one file of the results of all tiles.
#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/io/point_table.h"
#include "client/io/status_counts.h"
#include "client/io/table_file.h"
#include "client/tiles/tile_plan.h"

namespace curv {

// Returns the table of a result: the columns of the input, and those of the estimate.
using ResultJoin = std::function<PointTable(PointTable input, std::vector<Column> results)>;

// Writes the points of all inputs, in their order, with their results, as one file. Reads and writes large parts one
// after the other, whatever the order of the inputs, in the plan's memory. Where results are larger than memory, they
// are sorted on disk before, in the plan's directory. Formats that are written as a whole (TableStream) take only what
// fits into memory. Returns how many points have each status. `progress` is called with the points that are written.
// Errors:
// - FAILED_PRECONDITION: tiles are not done; an input has changed; a file of results is damaged
// - RESOURCE_EXHAUSTED: the format is written as a whole, and the result is too large for that
// - DATA_LOSS: the output, or the sorted results, cannot be written
// - CANCELLED: `stop` was requested
absl::StatusOr<StatusCounts> MergeTiles(const TilePlan& plan, const std::string& output, const SaveOptions& save,
                                        const ResultJoin& join, const std::stop_token& stop,
                                        const std::function<void(uint64_t points)>& progress);

}  // namespace curv
