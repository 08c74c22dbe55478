// Writes the summary that `curv estimate` prints when it is done.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "client/curvature_client.h"
#include "client/io/point_table.h"
#include "client/io/status_counts.h"

namespace curv {

// Holds everything about a finished estimate that its summary tells.
struct EstimateReport {
  std::string input;
  std::string output;
  std::string server{};  // "embedded" if there is none
  EstimateOptions options{};
  EstimateSummary summary{};
  // Wall-clock seconds that reading the input, the call, and writing the result took.
  double read_seconds = 0.0;
  double call_seconds = 0.0;
  double write_seconds = 0.0;
};

// Returns a line for each status that points have, and for `ok` in any case.
std::string StatusText(const StatusCounts& counts);
// Returns the counts of all statuses, by their words.
nlohmann::ordered_json StatusJson(const StatusCounts& counts);

// Returns several lines for people. `result` is what MakeResultTable returned.
std::string SummaryText(const EstimateReport& report, const PointTable& result);

// Returns the same as one line of JSON, for programs.
std::string SummaryJson(const EstimateReport& report, const PointTable& result);

}  // namespace curv
