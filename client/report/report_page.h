// Writes a result as a page that a browser shows without a network.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/io/point_table.h"
#include "client/report/served_report.h"

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

// Returns the page that shows what a ReportShelf holds (served_report.h), when a PageServer serves both: compressed
// files (laz_report.h) only if it `reads_laz`.
std::string MakeViewPage(bool reads_laz = false);

// Puts a report with these points on the shelf, as soon as its summary is known, then its points, block by block: in
// each block all points are spread evenly over the file. `generation` and `watches` are for the page: the number of the
// report, and whether others may follow. Ends early when a stop is requested. Errors and requirements are those of
// MakeReportPage.
absl::Status ServeReport(const PointTable& table, const ReportOptions& options, uint64_t generation, bool watches,
                         const std::stop_token& stop, ReportShelf& shelf);

// Puts a report on the shelf that says that the file of that name is waited for.
void ServeWaiting(const std::string& name, ReportShelf& shelf);

}  // namespace curv
