// What curv report and curv view share: their flags, and the page that follows from them.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "client/cli/command.h"
#include "client/io/point_table.h"
#include "client/report/report_page.h"

namespace curv {

struct PageFlags {
  std::string input{};
  std::string quantity{};
  std::string unit{};
  std::string up{};  // "" chooses it from the cloud
  uint64_t points = 1'000'000;
};

void AddPageFlags(CLI::App& command, PageFlags& flags);

// The file, and how it is to be shown.
struct PageContent {
  PointTable table;
  ReportOptions options;
};

// Reads the file. INVALID_ARGUMENT, naming it, if it cannot be shown.
absl::StatusOr<PageContent> ReadContent(const PageFlags& flags);

struct MadePage {
  std::string html;
  uint64_t points = 0;  // of the file
  uint64_t shown = 0;
};

// Reads the file and makes the page. Returns kOk, or prints what is wrong and returns its code.
ExitCode MakePage(const PageFlags& flags, MadePage& page);

}  // namespace curv
