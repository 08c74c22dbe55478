#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client/cli/command.h"
#include "client/cli/connection.h"
#include "client/cli/estimate_summary.h"
#include "client/cli/files/format_flags.h"
#include "client/cli/flags.h"
#include "client/cli/interrupt.h"
#include "client/cli/normals/normal_flags.h"
#include "client/cli/numbers.h"
#include "client/cli/result_columns.h"
#include "client/cli/scale/scale_flags.h"
#include "client/cli/table_vectors.h"
#include "client/io/oriented_cloud.h"
#include "client/io/table_file.h"

namespace curv {
namespace {

constexpr char kEstimateExamples[] =
    "Examples:\n"
    "  curv estimate scan.ply -o curvature.ply                             in this process\n"
    "  curv estimate scan.ply -o curvature.ply --server=localhost:50061   on a server\n"
    "  curv estimate scan.xyz -o curvature.csv --radius=0.05 --estimator=uniform --triangles=200\n"
    "  curv estimate scan.ply -o curvature.ply --auto                      with K and estimator that suit the scan\n"
    "  curv estimate terrain.pcd -o curvature.ply --normals=estimate --up  of a cloud without normals\n"
    "Output columns: x y z nx ny nz mean_curvature gaussian_curvature k1 k2 d1x d1y d1z d2x d2y d2z radius status (of "
    "the\n"
    "quantities asked for), then the other columns of the input.";

struct EstimateFlags {
  std::string input;
  std::string output;
  SaveOptions save;
  ConnectionFlags connection;
  int threads = 0;
  ScaleFlags scale;
  double timeout = 0.0;  // seconds; 0: none
  double connect_timeout = 1.5;
  std::string summary = "text";
  std::string color;
  NormalFlags normals;
  EstimateOptions options;
};

// Adds the contract's name for `word`, once.
void AddQuantity(const std::string& word, std::vector<std::string>& quantities) {
  const std::string name = ContractName(word);
  if (std::find(quantities.begin(), quantities.end(), name) == quantities.end()) quantities.push_back(name);
}

// Colors need their column. Throws CLI::ValidationError.
void CheckColor(const EstimateFlags& flags) {
  const std::vector<std::string>& quantities = flags.options.quantities;
  if (flags.color.empty() || quantities.empty()) return;
  if (std::find(quantities.begin(), quantities.end(), ContractName(flags.color)) != quantities.end()) return;
  throw CLI::ValidationError("--color", flags.color + " is not among --quantities");
}

double SecondsSince(absl::Time start) { return absl::ToDoubleSeconds(absl::Now() - start); }

// The server's error, with the flag that helps where there is one.
absl::Status WithRemedy(const absl::Status& status) {
  const std::string reason = ErrorReason(status);
  const char* remedy = nullptr;
  if (reason == "INVALID_POINT") remedy = "With --on-invalid=skip such points get a status";
  if (reason == "OPPOSED_NORMALS") {
    remedy = "--orient does that; with --on-opposed-normals=mark the points around get a status";
  }
  return remedy == nullptr ? status : absl::Status(status.code(), absl::StrCat(status.message(), ". ", remedy));
}

void PrintWarnings(const EstimateSummary& summary, bool oriented) {
  for (const EstimateWarning& warning : summary.warnings) {
    const bool can_orient = warning.code == "OPPOSED_NORMALS" && !oriented;
    PrintWarning(absl::StrCat(warning.message, can_orient ? ": try --orient" : ""));
  }
}

void PrintAdvice(const EstimateSummary& summary, const EstimateOptions& options, bool oriented) {
  if (summary.status_counts[static_cast<size_t>(PointStatus::kOk)] == 0 && summary.points > 0) {
    PrintNote("no point could be estimated: the summary tells why");
  }
  const uint64_t inconsistent = summary.status_counts[static_cast<size_t>(PointStatus::kInconsistentNormals)];
  if (inconsistent > 0 && !oriented && summary.warnings.empty()) {
    PrintNote(absl::StrCat("the normals around ", WithCommas(inconsistent),
                           " points contradict each other. Where they do not all point to one side of the surface, "
                           "signs of curvature are wrong: try --orient"));
  }
  const uint32_t degree = options.jet_degree.value_or(2), coefficients = (degree + 1) * (degree + 2) / 2;
  if (options.estimator == Estimator::kJetFitting && !options.radius && !options.automatic_scale &&
      options.neighbor_count < coefficients) {
    PrintNote(absl::StrCat("a jet of degree ", degree, " has ", coefficients,
                           " coefficients and needs as many neighbors: try --k=", coefficients, " or more"));
  }
}

ExitCode Run(const EstimateFlags& flags) {
  const InterruptWatch interrupt;
  EstimateReport report{.input = flags.input, .output = flags.output, .options = flags.options};
  report.server = flags.connection.server.empty() ? "embedded" : flags.connection.server;
  if (absl::Status status = CheckWritable(flags.output, flags.save); !status.ok())
    return Fail(ExitCode::kOutput, status);

  const absl::Time start = absl::Now();
  absl::StatusOr<PointTable> table = LoadTable(flags.input, flags.save.format);
  if (!table.ok()) return Fail(ExitCode::kInput, table.status());
  for (const std::string& note : table->notes) PrintNote(absl::StrCat(flags.input, ": ", note));
  std::string note;
  report.options.normals = OptionsFor(flags.normals, *table, note);
  absl::StatusOr<OrientedCloud> cloud = ExtractCloud(*table, NeedsOf(report.options.normals));
  if (!cloud.ok()) return Fail(ExitCode::kInput, absl::StrCat(flags.input, ": ", cloud.status().message()));
  if (!note.empty()) PrintNote(note);
  const bool were_given = flags.normals.source == NormalSource::kGiven;
  // The file has the normals in use, whatever else was asked for.
  if (!were_given && !report.options.quantities.empty()) AddQuantity("normals", report.options.quantities);
  report.read_seconds = SecondsSince(start);

  absl::StatusOr<std::unique_ptr<Connection>> connection = Connection::Create(flags.connection, flags.threads);
  if (!connection.ok()) return Fail(ExitCode::kUsage, connection.status());
  const absl::Time call_start = absl::Now();
  absl::StatusOr<CurvatureResult> result = CallServer(**connection, *cloud, report.options, interrupt.token());
  if (!result.ok()) return FailCall(WithRemedy(result.status()));
  report.call_seconds = SecondsSince(call_start);
  report.summary = result->summary;
  *cloud = OrientedCloud();

  const absl::Time write_start = absl::Now();
  if (flags.normals.source == NormalSource::kOrient) {
    PrintNote(absl::StrCat("negated ", WithCommas(TurnTable(result->normals, *table)), " normals"));
    result->normals.clear();  // the table's have more digits
  }
  PointTable output = MakeResultTable(*std::move(table), *std::move(result));
  if (!flags.color.empty()) AddColors(FindQuantity(flags.color)->column, output);
  PrintWarnings(report.summary, !were_given);
  PrintAdvice(report.summary, flags.options, !were_given);
  if (interrupt.token().stop_requested()) return Fail(ExitCode::kInterrupted, "interrupted");
  if (absl::Status status = SaveTable(output, flags.output, flags.save); !status.ok())
    return Fail(ExitCode::kOutput, status);
  report.write_seconds = SecondsSince(write_start);
  std::fputs((flags.summary == "json" ? SummaryJson(report, output) : SummaryText(report, output)).c_str(),
             SummaryStream(flags.output));
  return ExitCode::kOk;
}

// All estimators, the default first: "avg-hexagram [default], hexagram, ... or aso".
std::string EstimatorWords() {
  std::string words = absl::StrCat(std::string(EstimatorNames().front()), " [default]");
  for (const std::string_view name : EstimatorNames().subspan(1)) {
    absl::StrAppend(&words, name == EstimatorNames().back() ? " or " : ", ", std::string(name));
  }
  return words;
}

void AddEstimatorFlags(CLI::App& command, EstimateFlags& flags) {
  command
      .add_option_function<std::string>(
          "--estimator", [&flags](const std::string& name) { flags.options.estimator = *EstimatorOf(name); },
          EstimatorWords())
      ->check(CLI::IsMember(std::vector<std::string>(EstimatorNames().begin(), EstimatorNames().end())).description(""))
      ->option_text("NAME");
  AddScaleFlags(command, flags.scale);
  command
      .add_option("--triangles", flags.options.triangle_count, "triangles of uniform, at most so many of independent")
      ->check(Whole(1, 10'000))
      ->option_text("COUNT [100]");
  command.add_option("--rotations", flags.options.rotation_count, "hexagrams that avg-hexagram averages over")
      ->check(Whole(1, 4))
      ->option_text("COUNT [2]");
  command
      .add_option("--jet-degree", flags.options.jet_degree,
                  "degree of jet's polynomial, 2 to 4; 4: exact positions [2; with --k=auto: 4]")
      ->check(Whole(2, 4))
      ->option_text("DEGREE");
  command.add_flag("--even-weights", flags.options.even_weights,
                   "count all triangles of delaunay alike, as the paper does");
  command.add_option("--seed", flags.options.seed, "of the random estimators")
      ->check(Whole(0, ~uint64_t{0}))
      ->option_text("NUMBER [0]");
  command
      .add_option_function<double>(
          "--average-normal-weight", [&flags](double weight) { flags.options.average_normal_weight = weight; },
          "weight of the neighborhood's mean normal, 0 to 1 [0.5]")
      ->check(CLI::Range(0.0, 1.0).description(""))
      ->option_text("WEIGHT");
}

}  // namespace

void AddEstimate(CLI::App& app, Action& action) {
  auto flags = std::make_shared<EstimateFlags>();
  CLI::App* command = app.add_subcommand("estimate", "Estimate the curvature of a point cloud");
  command->footer(absl::StrCat(kEstimateExamples, "\n", kExitCodesHelp));
  command->add_option("input", flags->input, absl::StrCat("the cloud: ", kReadableFiles))
      ->required()
      ->option_text("IN");
  command->add_option("-o,--output", flags->output, absl::StrCat("the result: ", kWritableFiles))
      ->required()
      ->option_text("OUT");
  AddFormatFlags(*command, flags->save);
  AddConnectionFlags(*command, flags->connection);
  command->add_option("--threads", flags->threads, "workers without --server; 0 [default]: one a core")
      ->check(Whole(0, 1024))
      ->option_text("COUNT");
  AddEstimatorFlags(*command, *flags);
  AddSourceFlags(*command, flags->normals);
  command
      ->add_option("--connect-timeout", flags->connect_timeout,
                   "seconds until it is given up if no server answers at all [1.5]")
      ->check(FinitePositive())
      ->option_text("SECONDS");
  command->add_option("--timeout", flags->timeout, "seconds until the call is given up [none]")
      ->check(FinitePositive())
      ->option_text("SECONDS");
  command
      ->add_option("--max-attempts", flags->options.max_attempts, "times the cloud is sent if servers are unavailable")
      ->check(Whole(1, 100))
      ->option_text("COUNT [6]");
  command
      ->add_option_function<std::string>(
          "--priority",
          [flags](const std::string& priority) {
            flags->options.priority = priority == "batch" ? Priority::kBatch : Priority::kInteractive;
          },
          "interactive: somebody waits; batch: it can wait [up to 100,000 points interactive]")
      ->check(CLI::IsMember({"interactive", "batch"}).description(""))
      ->option_text("PRIORITY");
  command
      ->add_option_function<std::string>(
          "--on-invalid", [flags](const std::string& policy) { flags->options.skip_invalid = policy == "skip"; },
          "reject [default]: refuse a cloud with an unusable point; skip: give the point a status")
      ->check(CLI::IsMember({"reject", "skip"}).description(""))
      ->option_text("POLICY");
  command
      ->add_option_function<std::string>(
          "--on-opposed-normals",
          [flags](const std::string& policy) { flags->options.reject_opposed_normals = policy == "reject"; },
          "mark [default]: points near normals to opposite sides of one surface get a status; reject: refuse the cloud")
      ->check(CLI::IsMember({"mark", "reject"}).description(""))
      ->option_text("POLICY");
  command->add_option("--summary", flags->summary, "text [default] or json, on standard output")
      ->check(CLI::IsMember({"text", "json"}).description(""))
      ->option_text("FORMAT");
  command
      ->add_option_function<std::vector<std::string>>(
          "--quantities",
          [flags](const std::vector<std::string>& words) {
            for (const std::string& word : words) AddQuantity(word, flags->options.quantities);
          },
          "what to estimate, with commas between: mean, gaussian, k1, k2, d1, d2, radius, shape_index, curvedness or "
          "the "
          "contract's names; the result has no other columns [all of curvature but shape_index and curvedness]")
      ->delimiter(',')
      ->allow_extra_args(false)  // what follows the list is the input
      ->check(CLI::IsMember(QuantityWords()).description(""))
      ->option_text("LIST");
  command
      ->add_flag("--color{mean}", flags->color,
                 absl::StrCat("add columns red green blue for ", kQuantityWords, ": --color=gaussian; alone: mean"))
      ->check(CLI::IsMember({"mean", "gaussian", "k1", "k2"}).description(""));
  command->callback([flags, &action] {
    CheckColor(*flags);
    CheckSource(flags->normals);
    ApplyScale(flags->scale, flags->options);
    if (flags->timeout > 0.0) flags->options.timeout = absl::Seconds(flags->timeout);
    flags->options.connect_timeout = absl::Seconds(flags->connect_timeout);
    action = [flags] { return Run(*flags); };
  });
}

}  // namespace curv
