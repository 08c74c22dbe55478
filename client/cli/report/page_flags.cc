#include "client/cli/report/page_flags.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/cli/files/format_flags.h"
#include "client/cli/flags.h"
#include "client/cli/result_columns.h"
#include "client/io/las/las_header.h"
#include "client/io/las/laz_points.h"
#include "client/io/oriented_cloud.h"
#include "client/io/table_file.h"
#include "client/report/report_page.h"
#include "client/report/report_quantity.h"

namespace curv {
namespace {

constexpr uint64_t kMostPoints = 10'000'000;

// The column of a word or name; empty if none was given. `points` are a table or a compressed file.
template <typename Points>
absl::StatusOr<std::string> ChooseColumn(const Points& points, const std::string& quantity) {
  if (quantity.empty()) return quantity;
  const NamedQuantity* const named = FindQuantity(quantity);
  const std::string column = named == nullptr ? quantity : named->column;
  if (IsShownInReports(points, column)) return column;
  return absl::InvalidArgumentError(absl::StrCat("there is no quantity ", column, ": --quantity must be one of ",
                                                 kQuantityWords,
                                                 ", status, or the name of a column that is none of "
                                                 "positions, normals, directions and colors"));
}

// What messages call the input.
std::string Shown(const PageFlags& flags) { return flags.input == "-" ? "standard input" : flags.input; }

std::string TitleOf(const PageFlags& flags) {
  const std::string shown = Shown(flags);
  return shown.substr(shown.rfind('/') + 1);
}

// In a browser compressed points are taken apart by one thread.
constexpr uint64_t kUsualLazPoints = 1'000'000;

bool IsLas(const std::string& extension) { return extension == ".las" || extension == ".laz"; }

absl::Status BadInput(const PageFlags& flags, const absl::Status& status) {
  return absl::InvalidArgumentError(absl::StrCat(Shown(flags), ": ", status.message()));
}

ReportOptions OptionsOf(const PageFlags& flags, std::string column, uint64_t usual_points) {
  return {.title = TitleOf(flags),
          .unit = flags.unit,
          .quantity = std::move(column),
          .up_axis = flags.up.empty() ? std::nullopt : std::optional(flags.up[0]),
          .most_points = flags.points.value_or(usual_points)};
}

absl::StatusOr<PageContent> LazContent(const PageFlags& flags, std::string bytes) {
  absl::StatusOr<LazFile> laz = ReadLazFile(std::move(bytes));
  if (!laz.ok()) return BadInput(flags, laz.status());
  absl::StatusOr<std::string> column = ChooseColumn(*laz, flags.quantity);
  if (!column.ok()) return BadInput(flags, column.status());
  return PageContent{.table = {},
                     .laz = *std::move(laz),
                     .options = OptionsOf(flags, *std::move(column), std::min(flags.usual_points, kUsualLazPoints))};
}

absl::StatusOr<PageContent> TableContent(const PageFlags& flags, absl::StatusOr<PointTable> table) {
  if (!table.ok()) return table.status();
  if (absl::Status status = ExtractCloud(*table, {.normals = false}).status(); !status.ok()) {
    return BadInput(flags, status);
  }
  absl::StatusOr<std::string> column = ChooseColumn(*table, flags.quantity);
  if (!column.ok()) return BadInput(flags, column.status());
  return PageContent{.table = *std::move(table),
                     .laz = std::nullopt,
                     .options = OptionsOf(flags, *std::move(column), flags.usual_points)};
}

}  // namespace

void AddPageFlags(CLI::App& command, PageFlags& flags) {
  const std::string usual = absl::StrCat(flags.usual_points);
  command.add_option("result", flags.input, "a result of curv estimate")->required()->option_text("RESULT");
  AddInputFormat(command, flags.format);
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
  absl::StatusOr<PointTable> table;
  {
    absl::StatusOr<FileBytes> file = LoadBytes(flags.input, flags.format);
    if (!file.ok()) return file.status();
    if (!CanReadLaz() && IsLas(file->extension) && IsCompressedLas(file->bytes)) {
      return LazContent(flags, std::move(file->bytes));
    }
    table = TableOf(*file);
  }
  return TableContent(flags, std::move(table));
}

bool NeedsCodec(const PageFlags& flags) {
  const absl::StatusOr<std::string> extension = ReadableExtension(flags.input, flags.format);
  if (CanReadLaz() || !extension.ok() || !IsLas(*extension)) return false;
  constexpr size_t kHeaderBytes = 227;
  std::string start(kHeaderBytes, '\0');
  std::ifstream(flags.input, std::ios::binary).read(start.data(), kHeaderBytes);
  return *extension == ".laz" || IsCompressedLas(start);
}

ExitCode MakePage(const PageFlags& flags, MadePage& page) {
  const absl::StatusOr<PageContent> content = ReadContent(flags);
  if (!content.ok()) return Fail(ExitCode::kInput, content.status());
  absl::StatusOr<std::string> html = content->laz.has_value() ? MakeLazPage(*content->laz, content->options)
                                                              : MakeReportPage(content->table, content->options);
  if (absl::IsResourceExhausted(html.status())) return Fail(ExitCode::kFailed, html.status());
  if (!html.ok()) return Fail(ExitCode::kInput, absl::StrCat(Shown(flags), ": ", html.status().message()));
  const uint64_t points = content->laz.has_value() ? content->laz->layout.header.points : content->table.size();
  page = {.html = *std::move(html),
          .points = points,
          .shown = std::min<uint64_t>(points, content->options.most_points),
          .decompresses = content->laz.has_value()};
  return ExitCode::kOk;
}

}  // namespace curv
