#include "client/cli/files/estimate_files.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "client/cli/connection.h"
#include "client/cli/estimate_summary.h"
#include "client/cli/files/batch.h"
#include "client/cli/files/format_flags.h"
#include "client/cli/files/kept_inputs.h"
#include "client/cli/files/save_output.h"
#include "client/cli/interrupt.h"
#include "client/cli/numbers.h"
#include "client/cli/result_columns.h"
#include "client/cli/table_vectors.h"
#include "client/cli/tiles/estimate_in_tiles.h"
#include "client/cli/usage/flag_words.h"
#include "client/io/atomic_file.h"
#include "client/io/oriented_cloud.h"

namespace curv {
namespace {

double SecondsSince(absl::Time start) { return absl::ToDoubleSeconds(absl::Now() - start); }

// What helps where the server takes no cloud as large: tiles, or why tiles cannot.
std::string RemedyOfSize(const EstimateFlags& flags) {
  try {
    CheckEstimateInTiles(flags);
  } catch (const CLI::ValidationError& error) {
    return absl::StrCat("--tiles would estimate them in parts, but cannot here: ", error.what());
  }
  return "--tiles estimates them in parts, with the same result";
}

// The server's error about a cloud, with the flag that helps where there is one.
absl::Status WithRemedy(const absl::Status& status, size_t points, const EstimateFlags& flags) {
  const std::string reason = ErrorReason(status);
  if (reason == "TOO_MANY_POINTS" || reason == "MEMORY_LIMIT") {
    return {status.code(), absl::StrCat("the cloud has ", CountOf(points, "point"),
                                        ", more than the server takes: ", status.message(), ". ", RemedyOfSize(flags))};
  }
  const char* remedy = nullptr;
  if (reason == "INVALID_POINT") remedy = "With --on-invalid=skip such points get a status";
  if (reason == "OPPOSED_NORMALS") {
    remedy = "--orient does that; with --on-opposed-normals=mark the points around get a status";
  }
  return remedy == nullptr ? status : absl::Status(status.code(), absl::StrCat(status.message(), ". ", remedy));
}

void PrintWarnings(const EstimateSummary& summary, bool oriented, const std::string& title) {
  for (const EstimateWarning& warning : summary.warnings) {
    const char* flag = "";
    if (warning.code == "OPPOSED_NORMALS" && !oriented) flag = ": try --orient";
    if (warning.code == "NORMALS_OFF_SURFACE") flag = ": try --normals=estimate";
    if (warning.code == "OUTLIERS") flag = ": try --estimator=auto --k=50";
    PrintWarning(absl::StrCat(title, warning.message, flag));
  }
}

void PrintAdvice(const EstimateSummary& summary, const EstimateOptions& options, bool oriented,
                 const std::string& title) {
  const uint64_t inconsistent = summary.status_counts[static_cast<size_t>(PointStatus::kInconsistentNormals)];
  const bool is_warned_of_normals =
      std::any_of(summary.warnings.begin(), summary.warnings.end(), [](const EstimateWarning& warning) {
        return warning.code == "OPPOSED_NORMALS" || warning.code == "DOUBTFUL_ORIENTATION";
      });
  if (inconsistent > 0 && !oriented && !is_warned_of_normals) {
    PrintNote(absl::StrCat(title, "the normals around ", WithCommas(inconsistent),
                           " points contradict each other. Where they do not all point to one side of the surface, "
                           "signs of curvature are wrong: try --orient"));
  }
  const uint32_t degree = options.jet_degree.value_or(2), coefficients = (degree + 1) * (degree + 2) / 2;
  if (options.estimator == Estimator::kJetFitting && !options.radius && !options.automatic_scale &&
      options.neighbor_count < coefficients) {
    PrintNote(absl::StrCat(title, "a jet of degree ", degree, " has ", coefficients,
                           " coefficients and needs as many neighbors: try --k=", coefficients, " or more"));
  }
}

// Where nobody can tell how sure values are, those of standard errors are missing without a status that says why.
void NoteUnknownErrors(const CurvatureResult& result, const std::string& title) {
  constexpr double kLeastShare = 0.01;  // of the points with curvature
  size_t known = 0, unknown = 0;
  for (size_t i = 0; i < result.mean_standard_error.size() && i < result.status.size(); ++i) {
    if (result.status[i] != static_cast<uint8_t>(PointStatus::kOk)) continue;
    ++(std::isnan(result.mean_standard_error[i]) ? unknown : known);
  }
  if (unknown == 0 || static_cast<double>(unknown) < kLeastShare * static_cast<double>(known + unknown)) return;
  PrintNote(
      absl::StrCat(title, WithCommas(unknown), " of ", WithCommas(known + unknown),
                   " points with curvature have no standard error (NaN), since nothing tells it: where normals were "
                   "made of few noisy neighbors, beside seams, beside edges with few neighbors on a point's side, "
                   "and where the cloud is small"));
}

// What one file needs of a run: its names, where its progress is shown, and the connection, made for the first call.
struct FileTask {
  BatchFile file;
  std::optional<BatchShare> share;  // none if it is the only file
  const InterruptWatch& interrupt;
  std::unique_ptr<Connection>& connection;
};

// Of several files, the run's summary tells which were done before an interrupt: a file is then read to its end, which
// a pipe may never have.
absl::StatusOr<PointTable> LoadInput(const EstimateFlags& flags, const FileTask& task) {
  std::error_code unknown;
  const bool has_end = std::filesystem::is_regular_file(task.file.input, unknown);
  const InterruptWatch::EndsAtOnce at_once(task.interrupt, !task.share.has_value() || !has_end);
  return LoadTable(task.file.input, flags.input_format);
}

// Estimates one file. Reports the errors itself; returns the code and fills in `report` and `summary`.
ExitCode EstimateFile(const EstimateFlags& flags, const FileTask& task, EstimateReport& report, std::string& summary) {
  const auto& [input, output] = task.file;
  const std::string title = task.share ? task.share->title : "";  // before messages
  report = {.input = input, .output = output, .options = flags.options};
  report.server = flags.connection.server.empty() ? "embedded" : flags.connection.server;
  if (const ExitCode code = CheckOutput(output, flags.save); code != ExitCode::kOk) return code;

  const absl::Time start = absl::Now();
  absl::StatusOr<PointTable> table = LoadInput(flags, task);
  if (!table.ok()) return Fail(ExitCode::kInput, table.status());
  for (const std::string& note : table->notes) PrintNote(absl::StrCat(input, ": ", note));
  if (const std::string dropped = NoteOnDroppedColumns(*table); !dropped.empty()) {
    PrintNote(absl::StrCat(input, ": ", dropped));
  }
  std::string note;
  report.options.normals = OptionsFor(flags.normals, *table, note);
  CloudNeeds needs = NeedsOf(report.options.normals);
  needs.directions = flags.quantities.direction_columns;
  absl::StatusOr<OrientedCloud> cloud = ExtractCloud(*table, needs);
  if (!cloud.ok()) return Fail(ExitCode::kInput, absl::StrCat(input, ": ", cloud.status().message()));
  if (!note.empty()) PrintNote(title + note);
  const bool were_given = flags.normals.source == NormalSource::kGiven;
  // The file has the normals in use, whatever else was asked for.
  if (!were_given && !report.options.quantities.empty()) AddQuantity("normals", report.options.quantities);
  report.read_seconds = SecondsSince(start);

  if (task.connection == nullptr) {
    absl::StatusOr<std::unique_ptr<Connection>> made = Connection::Create(flags.connection, flags.threads);
    if (!made.ok()) return Fail(ExitCode::kUsage, made.status());
    task.connection = *std::move(made);
  }
  const absl::Time call_start = absl::Now();
  absl::StatusOr<CurvatureResult> result =
      CallServer(*task.connection, *cloud, report.options, task.interrupt.token(), task.share);
  if (!result.ok()) {
    return FailCall(WithRemedy(InFlags(result.status(), "normal-"), table->size(), flags),
                    absl::StrCat(input == "-" ? "standard input" : input, ": "));
  }
  report.call_seconds = SecondsSince(call_start);
  report.summary = result->summary;
  *cloud = OrientedCloud();

  const absl::Time write_start = absl::Now();
  if (flags.normals.source == NormalSource::kOrient) {
    PrintNote(absl::StrCat(title, "negated ", WithCommas(TurnTable(result->normals, *table)), " normals"));
    result->normals.clear();  // the table's have more digits
  }
  NoteUnknownErrors(*result, title);
  PointTable made = MakeResultTable(*std::move(table), *std::move(result));
  if (!flags.color.empty()) {
    const std::vector<uint32_t>& counts = report.options.neighbor_counts;
    AddColors(FindQuantity(flags.color)->column + (counts.empty() ? "" : ScaleSuffix(counts.back())), made);
  }
  PrintWarnings(report.summary, !were_given, title);
  PrintAdvice(report.summary, flags.options, !were_given, title);
  if (task.interrupt.token().stop_requested()) return Fail(ExitCode::kInterrupted, "interrupted");
  const InterruptWatch::EndsAtOnce at_once(task.interrupt, IsWrittenDirectly(output));
  const absl::Status saved = SaveOutput(made, output, flags.save);
  if (!saved.ok()) return Fail(ExitCode::kOutput, saved);
  report.write_seconds = SecondsSince(write_start);
  summary = flags.summary == "json" ? SummaryJson(report, made) : SummaryText(report, made);
  return ExitCode::kOk;
}

ExitCode RunOne(const EstimateFlags& flags) {
  const InterruptWatch interrupt;
  std::unique_ptr<Connection> connection;
  EstimateReport report;
  std::string summary;
  const FileTask task{{flags.inputs.front(), flags.output}, std::nullopt, interrupt, connection};
  const ExitCode code = EstimateFile(flags, task, report, summary);
  if (code == ExitCode::kOk) std::fputs(summary.c_str(), SummaryStream(flags.output));
  return code;
}

// One line about a file that is done.
std::string ShortSummary(const EstimateReport& report) {
  return absl::StrFormat("%s, %s ok, %.3f s", CountOf(report.summary.points, "point"),
                         WithCommas(report.summary.status_counts[static_cast<size_t>(PointStatus::kOk)]),
                         report.read_seconds + report.call_seconds + report.write_seconds);
}

ExitCode RunMany(const EstimateFlags& flags) {
  const absl::StatusOr<std::vector<BatchFile>> files = PlanBatch(flags.inputs, flags.output, flags.save.format);
  if (!files.ok()) return Fail(ExitCode::kUsage, files.status());
  const InterruptWatch interrupt;
  std::unique_ptr<Connection> connection;
  const auto process = [&](const BatchFile& file, const BatchShare& share) {
    EstimateReport report;
    BatchOutcome outcome;
    outcome.code = EstimateFile(flags, {file, share, interrupt, connection}, report, outcome.summary);
    outcome.points = report.summary.points;
    if (flags.summary != "json") outcome.summary = ShortSummary(report);
    return outcome;
  };
  const BatchOptions options{
      .directory = flags.output, .options = flags.given, .force = flags.force, .json = flags.summary == "json"};
  return RunBatch(*files, options, interrupt.token(), process);
}

}  // namespace

ExitCode EstimateFiles(const EstimateFlags& flags) {
  if (absl::Status status = CheckNoneNeedsAServer(flags.connection); !status.ok())
    return Fail(ExitCode::kUsage, status);
  if (IsDirectory(flags.output)) return RunMany(flags);
  if (absl::Status status = KeptInputs(flags.inputs).Check(flags.output); !status.ok())
    return Fail(ExitCode::kUsage, status);
  if (flags.inputs.size() == 1) return RunOne(flags);
  return Fail(ExitCode::kUsage,
              absl::StrCat("--output: ", flags.inputs.size(), " inputs need a directory, as ", flags.output, "/"));
}

}  // namespace curv
