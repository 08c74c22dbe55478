// What curv report and curv view share: their flags, and the page that follows from them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client/cli/command.h"
#include "client/io/point_table.h"
#include "client/report/laz_report.h"
#include "client/report/report_page.h"

namespace curv {

struct PageFlags {
  std::string input{};
  std::string format{};  // of an input whose name does not tell it
  std::string quantity{};
  std::string unit{};
  std::string up{};  // "" chooses it from the cloud
  uint64_t usual_points = 1'000'000;
  std::optional<uint64_t> points{};  // none: the usual number
};

void AddPageFlags(CLI::App& command, PageFlags& flags);

// The file, and how it is to be shown.
struct PageContent {
  PointTable table;            // empty if there is a compressed file
  std::optional<LazFile> laz;  // that this program cannot decompress, and the page can
  ReportOptions options;
};

// Reads the file. INVALID_ARGUMENT, naming it, if it cannot be shown.
absl::StatusOr<PageContent> ReadContent(const PageFlags& flags);

// Returns whether the page of the file has to decompress it, as far as its name and its first bytes tell.
bool NeedsCodec(const PageFlags& flags);

struct MadePage {
  std::string html;
  uint64_t points = 0;  // of the file
  uint64_t shown = 0;
  bool decompresses = false;  // whether only the page will see the points
};

// Reads the file and makes the page. Returns kOk, or prints what is wrong and returns its code.
ExitCode MakePage(const PageFlags& flags, MadePage& page);

}  // namespace curv
