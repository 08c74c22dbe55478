// Writes a result as a page that a browser shows without a network.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client/io/point_table.h"

namespace curv {

struct ReportOptions {
  std::string title{};             // what the page calls the result: the file's name
  std::string unit{};              // the cloud's length unit; DEFAULT: none is known
  std::string quantity{};          // the column that is shown first; DEFAULT: the first quantity
  std::optional<char> up_axis{};   // 'y' or 'z'; DEFAULT: as ChoosePose chooses
  size_t most_points = 1'000'000;  // DEFAULT: 1,000,000; more are thinned
};

// A report holds no more quantities than this; of more than 500,000 points as many as make kMostValues, but at least 6:
// curvatures, radius and one more, with which a million points take less than 30 MB. The page names what is left out.
inline constexpr size_t kMostQuantities = 12;
inline constexpr size_t kFewestQuantities = 6;
inline constexpr size_t kMostValues = 6'000'000;

// Returns the page: its program, and of each point the position to 16 bits of the bounding box, quantities as binary16
// numbers, normal and directions to 0.7 degrees, and status. All texts come from JSON in which no `<` stands, so that
// no file can add to the page. INVALID_ARGUMENT if no point has a finite position; RESOURCE_EXHAUSTED if memory runs
// out. REQUIRES: ExtractCloud(table, {.normals = false}) succeeds; options.quantity is empty or
// IsShownInReports.
absl::StatusOr<std::string> MakeReportPage(const PointTable& table, const ReportOptions& options);

}  // namespace curv
