#include "client/cli/report/page_flags.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/cli/flags.h"
#include "client/cli/result_columns.h"
#include "client/io/oriented_cloud.h"
#include "client/io/table_file.h"
#include "client/report/report_page.h"
#include "client/report/report_quantity.h"

namespace curv {
namespace {

constexpr uint64_t kMostPoints = 10'000'000;

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

std::string BaseName(const std::string& path) { return path.substr(path.rfind('/') + 1); }

}  // namespace

void AddPageFlags(CLI::App& command, PageFlags& flags) {
  const std::string usual = absl::StrCat(flags.points);
  command.add_option("result", flags.input, "a result of curv estimate")->required()->option_text("RESULT");
  command
      .add_option("--quantity", flags.quantity,
                  absl::StrCat("shown first: ", kQuantityWords, ", status, or the name of a column [mean]"))
      ->option_text("NAME");
  command.add_option("--unit", flags.unit, "the cloud's length unit: mm makes the page say 1/mm")->option_text("NAME");
  command.add_option("--up", flags.up, "axis that points up: y or z [chosen from the cloud]")
      ->check(CLI::IsMember({"y", "z"}).description(""))
      ->option_text("AXIS");
  command
      .add_option("--points", flags.points,
                  absl::StrCat("the most points that the page holds; more are thinned [", usual, "]"))
      ->check(Whole(1, kMostPoints))
      ->option_text("COUNT");
}

absl::StatusOr<PageContent> ReadContent(const PageFlags& flags) {
  absl::StatusOr<PointTable> table = LoadTable(flags.input);
  if (!table.ok()) return table.status();
  const auto bad_input = [&](const absl::Status& status) {
    return absl::InvalidArgumentError(absl::StrCat(flags.input, ": ", status.message()));
  };
  if (absl::Status status = ExtractCloud(*table, {.normals = false}).status(); !status.ok()) return bad_input(status);
  const absl::StatusOr<std::string> column = ChooseColumn(*table, flags.quantity);
  if (!column.ok()) return bad_input(column.status());
  return PageContent{.table = *std::move(table),
                     .options = {.title = BaseName(flags.input),
                                 .unit = flags.unit,
                                 .quantity = *column,
                                 .up_axis = flags.up.empty() ? std::nullopt : std::optional(flags.up[0]),
                                 .most_points = flags.points}};
}

ExitCode MakePage(const PageFlags& flags, MadePage& page) {
  const absl::StatusOr<PageContent> content = ReadContent(flags);
  if (!content.ok()) return Fail(ExitCode::kInput, content.status());
  absl::StatusOr<std::string> html = MakeReportPage(content->table, content->options);
  if (absl::IsResourceExhausted(html.status())) return Fail(ExitCode::kFailed, html.status());
  if (!html.ok()) return Fail(ExitCode::kInput, absl::StrCat(flags.input, ": ", html.status().message()));
  const uint64_t points = content->table.size();
  page = {.html = *std::move(html), .points = points, .shown = std::min(points, flags.points)};
  return ExitCode::kOk;
}

}  // namespace curv
