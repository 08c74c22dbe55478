#include <cstdio>
#include <memory>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/cli/command.h"
#include "client/cli/interrupt.h"
#include "client/cli/numbers.h"
#include "client/cli/report/page_flags.h"
#include "client/io/atomic_file.h"

namespace curv {
namespace {

constexpr char kReportExamples[] =
    "Examples:\n"
    "  curv report result.ply -o report.html\n"
    "  curv report result.ply -o report.html --quantity=gaussian --unit=mm --up=y\n"
    "The page is one file, which a browser opens without a network: turn the cloud, choose quantity, colors and "
    "range,\n"
    "click a point to read its values. The page itself decompresses a LAZ or COPC file that this curv cannot.";

struct ReportFlags {
  PageFlags page;
  std::string output;
};

absl::Status SavePage(const std::string& page, const std::string& path) {
  const UninterruptedWrite write(path);
  absl::StatusOr<AtomicFile> file = AtomicFile::Create(path);
  if (!file.ok()) return file.status();
  if (absl::Status status = file->Append(page); !status.ok()) return status;
  return file->Commit();
}

ExitCode Run(const ReportFlags& flags) {
  if (!absl::EndsWithIgnoreCase(flags.output, ".html")) {
    return Fail(ExitCode::kOutput, absl::StrCat(flags.output, ": reports are written as .html"));
  }
  MadePage page;
  if (const ExitCode code = MakePage(flags.page, page); code != ExitCode::kOk) return code;
  if (absl::Status status = SavePage(page.html, flags.output); !status.ok()) return Fail(ExitCode::kOutput, status);
  std::printf("%s: %s of %s of %s, %sB%s\n", ShownOutput(flags.output).c_str(), WithCommas(page.shown).c_str(),
              CountOf(page.points, "point").c_str(), ShownInput(flags.page.input).c_str(),
              WithPrefix(static_cast<double>(page.html.size())).c_str(),
              page.decompresses ? ", which the page decompresses" : "");
  return ExitCode::kOk;
}

}  // namespace

void AddReport(CLI::App& app, Action& action) {
  auto flags = std::make_shared<ReportFlags>();
  CLI::App* command = app.add_subcommand("report", "Write a result as a page to look at in a browser");
  command->footer(absl::StrCat(kReportExamples, "\n", kExitCodesHelp));
  AddPageFlags(*command, flags->page);
  command->add_option("-o,--output", flags->output, "the page: .html")->required()->option_text("HTML");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
