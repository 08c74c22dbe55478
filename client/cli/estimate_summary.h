// What `curv estimate` says when it is done.
#pragma once

#include <string>

#include "client/curvature_client.h"
#include "client/io/point_table.h"

namespace curv {

// Everything about a finished estimate that its summary tells.
struct EstimateReport {
  std::string input;
  std::string output;
  std::string server{};  // "embedded" if there is none
  EstimateOptions options{};
  EstimateSummary summary{};
  // Wall-clock seconds of the client's parts.
  double read_seconds = 0.0;
  double call_seconds = 0.0;
  double write_seconds = 0.0;
};

// Several lines for people. `result` is what MakeResultTable returned.
std::string SummaryText(const EstimateReport& report, const PointTable& result);

// The same in one line of JSON.
std::string SummaryJson(const EstimateReport& report, const PointTable& result);

}  // namespace curv
