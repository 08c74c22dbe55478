// curv normals and curv orient: the normals of a cloud, without curvature.
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/cli/command.h"
#include "client/cli/connection.h"
#include "client/cli/files/format_flags.h"
#include "client/cli/files/kept_inputs.h"
#include "client/cli/files/save_output.h"
#include "client/cli/flags.h"
#include "client/cli/interrupt.h"
#include "client/cli/json.h"
#include "client/cli/normals/normal_flags.h"
#include "client/cli/normals/normals_text.h"
#include "client/cli/numbers.h"
#include "client/cli/result_columns.h"
#include "client/cli/table_vectors.h"
#include "client/cli/usage/flag_words.h"
#include "client/cli/usage/option_conflicts.h"
#include "client/io/atomic_file.h"
#include "client/io/oriented_cloud.h"
#include "client/io/point_status.h"
#include "client/io/table_file.h"

namespace curv {
namespace {

constexpr char kNormalsExamples[] =
    "Examples:\n"
    "  curv normals scan.xyz -o normals.ply                        as many neighbors as the points' noise asks for\n"
    "  curv normals terrain.pcd -o normals.ply --up                no normal points down\n"
    "  curv normals room.ply -o normals.ply --viewpoint=0,0,1.7    all normals point to the scanner\n"
    "Output columns: x y z nx ny nz normal_residual normal_variance_ratio status, then the other columns of the "
    "input.\n"
    "A point without a normal has NaN and a status that says why. curv estimate --normals=estimate does the same on "
    "the\n"
    "way. Viewpoints of the input are used: VIEWPOINT of PCD, if it is not 0 0 0, and for each point the columns\n"
    "vp_x vp_y vp_z, viewpoint_x ..., sensor_x ... or scanner_x ...";

constexpr char kOrientExamples[] =
    "Example:\n"
    "  curv orient scan.ply -o oriented.ply\n"
    "Normals that were estimated point by point know the surface's direction but not its side. This command negates\n"
    "some of them so that neighbors agree: outward on closed surfaces, to the side of the majority on open ones. All\n"
    "other columns stay as they are. curv estimate --normals=orient does the same on the way.";

struct MakeNormalsFlags {
  std::string input;
  std::string output;
  std::string input_format;
  SaveOptions save;
  ConnectionFlags connection;
  NormalFlags normals;
  int threads = 0;
  double timeout = 0.0;  // seconds; 0: none
  std::string summary = "text";
  EstimateOptions options;
};

// Writes the normals into the table, and returns how many were turned.
uint64_t TakeNormals(bool were_given, CurvatureResult result, PointTable& table) {
  if (were_given) return TurnTable(result.normals, table);
  table = MakeResultTable(std::move(table), std::move(result));
  return 0;
}

// Such points are skipped, and no count of normals has them.
void NoteUnusable(const EstimateSummary& summary) {
  const uint64_t count = summary.status_counts[static_cast<size_t>(PointStatus::kInvalidInput)];
  if (count == 0) return;
  PrintNote(absl::StrCat(CountOf(count, "point"), " cannot be used (invalid_input): ", count == 1 ? "its" : "their",
                         " position, normal or viewpoint is not finite, or the normal is 0"));
}

void PrintSummary(const MakeNormalsFlags& flags, const EstimateSummary& summary, uint64_t turned) {
  if (flags.summary == "json") {
    nlohmann::ordered_json json = {{"input", flags.input},
                                   {"output", flags.output},
                                   {"request_id", summary.request_id},
                                   {"points", summary.points},
                                   {"normals", NormalsJson(*summary.normals)},
                                   {"warnings", WarningsJson(summary)}};
    std::fputs(ToJsonLine(json).c_str(), SummaryStream(flags.output));
  } else if (flags.normals.source == NormalSource::kOrient) {
    std::fprintf(SummaryStream(flags.output), "%s: negated %s of %s\n", ShownOutput(flags.output).c_str(),
                 WithCommas(turned).c_str(), CountOf(summary.points, "normal").c_str());
  } else {
    std::fprintf(SummaryStream(flags.output), "%s: %s, %s\n", ShownOutput(flags.output).c_str(),
                 CountOf(summary.points, "point").c_str(), NormalsText(*summary.normals).c_str());
  }
}

ExitCode Run(MakeNormalsFlags& flags) {
  const InterruptWatch interrupt;
  if (const ExitCode code = CheckOutput(flags.output, flags.save); code != ExitCode::kOk) return code;
  if (absl::Status status = KeptInputs({flags.input}).Check(flags.output); !status.ok())
    return Fail(ExitCode::kUsage, status);
  if (absl::Status status = CheckNoneNeedsAServer(flags.connection); !status.ok())
    return Fail(ExitCode::kUsage, status);
  absl::StatusOr<PointTable> table = [&] {
    const InterruptWatch::EndsAtOnce at_once(interrupt);
    return LoadTable(flags.input, flags.input_format);
  }();
  if (!table.ok()) return Fail(ExitCode::kInput, table.status());
  for (const std::string& note : table->notes) PrintNote(absl::StrCat(flags.input, ": ", note));
  std::string note;
  EstimateOptions& options = flags.options;
  options.normals = OptionsFor(flags.normals, *table, note);
  const absl::StatusOr<OrientedCloud> cloud = ExtractCloud(*table, NeedsOf(options.normals));
  if (!cloud.ok()) return Fail(ExitCode::kInput, absl::StrCat(flags.input, ": ", cloud.status().message()));
  if (!note.empty()) PrintNote(note);

  absl::StatusOr<std::unique_ptr<Connection>> connection = Connection::Create(flags.connection, flags.threads);
  if (!connection.ok()) return Fail(ExitCode::kUsage, connection.status());
  const bool were_given = flags.normals.source == NormalSource::kOrient;
  if (const std::string dropped = NoteOnDroppedColumns(*table); !were_given && !dropped.empty()) {
    PrintNote(absl::StrCat(flags.input, ": ", dropped));
  }
  options.quantities = {"normals"};
  if (!were_given) options.quantities.emplace_back("normal_quality");
  options.skip_invalid = true;
  absl::StatusOr<CurvatureResult> result = CallServer(**connection, *cloud, options, interrupt.token());
  if (!result.ok()) return FailCall(InFlags(result.status(), ""));
  const EstimateSummary summary = result->summary;
  const uint64_t turned = TakeNormals(were_given, *std::move(result), *table);
  for (const EstimateWarning& warning : summary.warnings) PrintWarning(warning.message);
  NoteUnusable(summary);
  if (interrupt.token().stop_requested()) return Fail(ExitCode::kInterrupted, "interrupted");
  const InterruptWatch::EndsAtOnce at_once(interrupt, IsWrittenDirectly(flags.output));
  if (absl::Status status = SaveOutput(*table, flags.output, flags.save); !status.ok())
    return Fail(ExitCode::kOutput, status);
  PrintSummary(flags, summary, turned);
  return ExitCode::kOk;
}

CLI::App* AddCommand(CLI::App& app, const char* name, const char* what, const char* examples,
                     const std::shared_ptr<MakeNormalsFlags>& flags, Action& action) {
  CLI::App* command = app.add_subcommand(name, what);
  command->footer(absl::StrCat(examples, "\n", kExitCodesHelp));
  command->add_option("input", flags->input, absl::StrCat("the cloud: ", kReadableFiles))
      ->required()
      ->option_text("IN");
  AddOutput(*command, flags->output, absl::StrCat("the cloud: ", kWritableFiles));
  AddFormats(*command, flags->input_format, flags->save);
  AddConnectionFlags(*command, flags->connection);
  command->add_option("--threads", flags->threads, "workers without --server; 0 [default]: one a core")
      ->check(Whole(0, 1024))
      ->excludes(command->get_option("--server"))
      ->option_text("COUNT");
  AddSideFlags(*command, flags->normals);
  command->add_option("--timeout", flags->timeout, "seconds until the call is given up [none]")
      ->check(FinitePositive())
      ->option_text("SECONDS");
  command->add_option("--summary", flags->summary, "text [default] or json, on standard output")
      ->check(CLI::IsMember({"text", "json"}).description(""))
      ->option_text("FORMAT");
  command->callback([flags, &action] {
    CheckNormalCount("", flags->normals);
    if (flags->timeout > 0.0) flags->options.timeout = absl::Seconds(flags->timeout);
    action = [flags] { return Run(*flags); };
  });
  return command;
}

}  // namespace

void AddNormals(CLI::App& app, Action& action) {
  auto flags = std::make_shared<MakeNormalsFlags>();
  flags->normals.source = NormalSource::kEstimate;
  CLI::App* command =
      AddCommand(app, "normals", "Estimate the normals of a cloud from its positions", kNormalsExamples, flags, action);
  AddMethodFlags(*command, "", flags->normals);
}

void AddOrient(CLI::App& app, Action& action) {
  auto flags = std::make_shared<MakeNormalsFlags>();
  flags->normals.source = NormalSource::kOrient;
  AddCommand(app, "orient", "Make the normals of a cloud point to one side of its surface", kOrientExamples, flags,
             action);
}

}  // namespace curv
