// Writes a compressed file of points, LAZ or COPC, as a page that decompresses it in the browser.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/io/las/las_layout.h"
#include "client/report/report_page.h"
#include "client/report/served_report.h"

namespace curv {

// The most bytes that a page takes of a compressed file, and of its points once they are decompressed: a browser holds
// both, and no text of more than 512 MiB.
inline constexpr uint64_t kMostLazBytes = uint64_t{1} << 28;
inline constexpr uint64_t kMostDecompressedBytes = uint64_t{1} << 30;

// A compressed file whose points nobody has seen so far.
struct LazFile {
  std::string bytes;
  LasLayout layout;
};

// Takes the bytes of a whole file. INVALID_ARGUMENT naming what is wrong if they are no LAZ or COPC file that the
// page's codec reads (LAS 1.2 to 1.4, point formats 0 to 3 and 6 to 8), if the file holds no points, if its table of
// chunks or its bounding box cannot be, or if it exceeds a limit above. What only decompression shows, the page says.
absl::StatusOr<LazFile> ReadLazFile(std::string bytes);

// Whether reports can show the column of that name. REQUIRES: the file comes from ReadLazFile.
bool IsShownInReports(const LazFile& file, const std::string& column);

// Returns the page: its program, a codec, the file as it is, and where in a record what stands. The page makes of these
// what MakeReportPage makes of a table. REQUIRES: options.quantity is empty or IsShownInReports.
std::string MakeLazPage(const LazFile& file, const ReportOptions& options);

// Puts a report with this file on the shelf, for the page of MakeViewPage(/*reads_laz=*/true). `generation` and
// `watches` as for ServeReport.
void ServeLaz(LazFile file, const ReportOptions& options, uint64_t generation, bool watches, ReportShelf& shelf);

}  // namespace curv
