#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/cli/command.h"
#include "client/cli/flags.h"
#include "client/cli/numbers.h"
#include "client/cli/result_columns.h"
#include "client/io/atomic_file.h"
#include "client/io/oriented_cloud.h"
#include "client/io/table_file.h"
#include "client/report/report_page.h"
#include "client/report/report_quantity.h"

namespace curv {
namespace {

constexpr uint64_t kMostPoints = 10'000'000;
constexpr char kReportExamples[] =
    "Examples:\n"
    "  curv report result.ply -o report.html\n"
    "  curv report result.ply -o report.html --quantity=gaussian --unit=mm --up=y\n"
    "The page is one file, which a browser opens without a network: turn the cloud, choose quantity, colors and "
    "range,\n"
    "click a point to read its values.";

struct ReportFlags {
  std::string input;
  std::string output;
  std::string quantity;
  std::string unit;
  std::string up = "z";
  uint64_t points = 1'000'000;
};

// The column of a word or name; empty if none was given.
absl::StatusOr<std::string> ChooseColumn(const PointTable& table, const std::string& quantity) {
  if (quantity.empty()) return quantity;
  const NamedQuantity* const named = FindQuantity(quantity);
  const std::string column = named == nullptr ? quantity : named->column;
  if (IsShownInReports(table, column)) return column;
  return absl::InvalidArgumentError(absl::StrCat("there is no quantity ", column, ": --quantity must be one of ",
                                                 kQuantityWords,
                                                 ", status, or the name of a column that is none of "
                                                 "positions, normals, directions and colors"));
}

absl::Status SavePage(const std::string& page, const std::string& path) {
  absl::StatusOr<AtomicFile> file = AtomicFile::Create(path);
  if (!file.ok()) return file.status();
  if (absl::Status status = file->Append(page); !status.ok()) return status;
  return file->Commit();
}

std::string BaseName(const std::string& path) { return path.substr(path.rfind('/') + 1); }

ExitCode Run(const ReportFlags& flags) {
  if (!absl::EndsWithIgnoreCase(flags.output, ".html")) {
    return Fail(ExitCode::kOutput, absl::StrCat(flags.output, ": reports are written as .html"));
  }
  const absl::StatusOr<PointTable> table = LoadTable(flags.input);
  if (!table.ok()) return Fail(ExitCode::kInput, table.status());
  const auto bad_input = [&](const absl::Status& status) {
    return Fail(ExitCode::kInput, absl::StrCat(flags.input, ": ", status.message()));
  };
  if (absl::Status status = ExtractCloud(*table, {.normals = false}).status(); !status.ok()) return bad_input(status);
  const absl::StatusOr<std::string> column = ChooseColumn(*table, flags.quantity);
  if (!column.ok()) return bad_input(column.status());
  const absl::StatusOr<std::string> page = MakeReportPage(*table, {.title = BaseName(flags.input),
                                                                   .unit = flags.unit,
                                                                   .quantity = *column,
                                                                   .up_axis = flags.up[0],
                                                                   .most_points = flags.points});
  if (absl::IsResourceExhausted(page.status())) return Fail(ExitCode::kFailed, page.status());
  if (!page.ok()) return bad_input(page.status());
  if (absl::Status status = SavePage(*page, flags.output); !status.ok()) return Fail(ExitCode::kOutput, status);
  std::printf("%s: %s of %s points of %s, %sB\n", flags.output.c_str(),
              WithCommas(std::min<uint64_t>(table->size(), flags.points)).c_str(), WithCommas(table->size()).c_str(),
              flags.input.c_str(), WithPrefix(static_cast<double>(page->size())).c_str());
  return ExitCode::kOk;
}

}  // namespace

void AddReport(CLI::App& app, Action& action) {
  auto flags = std::make_shared<ReportFlags>();
  CLI::App* command = app.add_subcommand("report", "Write a result as a page to look at in a browser");
  command->footer(absl::StrCat(kReportExamples, "\n", kExitCodesHelp));
  command->add_option("result", flags->input, "a result of curv estimate")->required()->option_text("RESULT");
  command->add_option("-o,--output", flags->output, "the page: .html")->required()->option_text("HTML");
  command
      ->add_option("--quantity", flags->quantity,
                   absl::StrCat("shown first: ", kQuantityWords, ", status, or the name of a column [mean]"))
      ->option_text("NAME");
  command->add_option("--unit", flags->unit, "the cloud's length unit: mm makes the page say 1/mm")
      ->option_text("NAME");
  command->add_option("--up", flags->up, "axis that points up: z [default] or y")
      ->check(CLI::IsMember({"y", "z"}).description(""))
      ->option_text("AXIS");
  command->add_option("--points", flags->points, "the most points that the page holds; more are thinned [1000000]")
      ->check(Whole(1, kMostPoints))
      ->option_text("COUNT");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
