#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/cli/command.h"
#include "client/cli/estimate_flags.h"
#include "client/cli/files/batch.h"
#include "client/cli/files/estimate_files.h"
#include "client/cli/files/format_flags.h"
#include "client/cli/flags.h"
#include "client/cli/normals/normal_flags.h"
#include "client/cli/quantities/quantity_flags.h"
#include "client/cli/result_columns.h"
#include "client/cli/scale/scale_flags.h"
#include "client/cli/tiles/estimate_in_tiles.h"
#include "client/cli/usage/option_conflicts.h"
#include "client/io/table_file.h"

namespace curv {
namespace {

constexpr char kEstimateExamples[] =
    "Examples:\n"
    "  curv estimate scan.ply -o curvature.ply                             in this process\n"
    "  curv estimate scan.ply -o curvature.ply --server=localhost:50061   on a server\n"
    "  curv estimate scan.xyz -o curvature.csv --radius=0.05 --estimator=uniform --triangles=200\n"
    "  curv estimate scan.ply -o curvature.ply --auto                      with K and estimator that suit the scan\n"
    "  curv estimate scan.ply -o curvature.ply --auto --also=standard_errors  with how sure each value is\n"
    "  curv estimate terrain.las -o curvature.las --normals=estimate --up  of a cloud without normals\n"
    "  curv estimate scans/*.ply -o results/                               of many, those that are not finished yet\n"
    "  curv estimate large.ply -o curvature.ply --tiles                    of a file larger than the server takes\n"
    "Output columns: x y z nx ny nz mean_curvature gaussian_curvature k1 k2 d1x d1y d1z d2x d2y d2z radius status (of "
    "the\n"
    "quantities asked for), then the other columns of the input.";

// The options that change no result.
std::set<std::string> WithoutEffect() {
  return {"input",          "--output",     "--force",   "--tiles",   "--tiles-directory",
          "--server",       "--tls",        "--ca",      "--cert",    "--key",
          "--server-name",  "--token-file", "--threads", "--timeout", "--connect-timeout",
          "--max-attempts", "--priority",   "--summary", "--help",    "--send-token-in-plain-text"};
}

// Colors need their column. Throws CLI::ValidationError.
void CheckColor(const EstimateFlags& flags) {
  const std::vector<std::string>& quantities = flags.options.quantities;
  if (flags.color.empty() || quantities.empty()) return;
  if (std::find(quantities.begin(), quantities.end(), ContractName(flags.color)) != quantities.end()) return;
  throw CLI::ValidationError("--color", flags.color + " is not among --quantities");
}

// Flags that some estimators alone read.
struct EstimatorFlag {
  const char* name;
  std::vector<Estimator> estimators;
};

std::vector<EstimatorFlag> EstimatorFlags() {
  return {{"--triangles", {Estimator::kUniform, Estimator::kIndependent}},
          {"--seed", {Estimator::kUniform, Estimator::kIndependent}},
          {"--rotations", {Estimator::kAvgHexagram, Estimator::kAuto}},
          {"--jet-degree", {Estimator::kJetFitting}},
          {"--regression-degree", {Estimator::kNormalRegression}},
          {"--even-weights", {Estimator::kDelaunay}},
          {"--project", {Estimator::kAlgebraicShapeOperator}}};
}

// Normals alone are made without an estimate. Throws CLI::ValidationError if a flag is given that one alone reads.
void CheckNoneIsGiven(const CLI::App& command) {
  std::vector<std::string> names = {"--estimator", "--auto",       "--k",         "--radius",
                                    "--k-range",   "--max-radius", "--per-cloud", "--average-normal-weight"};
  for (const EstimatorFlag& flag : EstimatorFlags()) names.emplace_back(flag.name);
  for (const std::string& name : names) {
    if (command.get_option(name)->count() == 0) continue;
    throw CLI::ValidationError(name, "needs a quantity of curvature among --quantities; normals do not read it");
  }
}

// All estimators, the default first: "avg-hexagram [default], hexagram, ... or aso".
std::string EstimatorWords() {
  std::string words = absl::StrCat(std::string(EstimatorNames().front()), " [default]");
  for (const std::string_view name : EstimatorNames().subspan(1)) {
    absl::StrAppend(&words, name == EstimatorNames().back() ? " or " : ", ", std::string(name));
  }
  return words;
}

// What is read, and what is written where.
void AddFileFlags(CLI::App& command, EstimateFlags& flags) {
  command.add_option("input", flags.inputs, absl::StrCat("the cloud, or several: ", kReadableFiles))
      ->required()
      ->option_text("IN...");
  AddOutput(command, flags.output,
            absl::StrCat("the result: ", kWritableFiles, "; or a directory, for a result of each input"));
  command.add_flag("--force", flags.force, "with a directory: estimate finished files again");
  CLI::Option* tiles = command.add_flag(
      "--tiles", flags.tiles,
      "estimate a file that is larger than the server takes in tiles, with the same result (docs/scale.md)");
  command
      .add_option("--tiles-directory", flags.tiles_directory,
                  "where tiles are kept until all are done, so that an interrupted command goes on [OUT.tiles]")
      ->needs(tiles)
      ->check(NotEmpty())
      ->option_text("DIR");
  AddFormats(command, flags.input_format, flags.save);
}

// Where it is computed.
void AddServerFlags(CLI::App& command, EstimateFlags& flags) {
  AddConnectionFlags(command, flags.connection);
  command.add_option("--threads", flags.threads, "workers without --server; 0 [default]: one a core")
      ->check(Whole(0, 1024))
      ->excludes(command.get_option("--server"))
      ->option_text("COUNT");
}

// How long a call may take, how often it is tried, and who goes first.
void AddCallFlags(CLI::App& command, EstimateFlags& flags) {
  command
      .add_option("--connect-timeout", flags.connect_timeout,
                  "seconds until it is given up if no server answers at all [1.5]")
      ->check(FinitePositive())
      ->option_text("SECONDS");
  command.add_option("--timeout", flags.timeout, "seconds until the call is given up [none]")
      ->check(FinitePositive())
      ->option_text("SECONDS");
  command
      .add_option("--max-attempts", flags.options.max_attempts, "times the cloud is sent if servers are unavailable")
      ->check(Whole(1, 100))
      ->option_text("COUNT [6]");
  command
      .add_option_function<std::string>(
          "--priority",
          [&flags](const std::string& priority) {
            flags.options.priority = priority == "batch" ? Priority::kBatch : Priority::kInteractive;
          },
          "interactive: somebody waits; batch: it can wait [up to 100,000 points interactive]")
      ->check(CLI::IsMember({"interactive", "batch"}).description(""))
      ->option_text("PRIORITY");
}

void AddOpposedNormalsFlag(CLI::App& command, EstimateFlags& flags) {
  command
      .add_option_function<std::string>(
          "--on-opposed-normals",
          [&flags](const std::string& policy) { flags.options.reject_opposed_normals = policy == "reject"; },
          "mark [default]: points near normals to opposite sides of one surface get a status; reject: refuse the cloud")
      ->check(CLI::IsMember({"mark", "reject"}).description(""))
      ->option_text("POLICY");
}

void AddSummaryFlag(CLI::App& command, EstimateFlags& flags) {
  command.add_option("--summary", flags.summary, "text [default] or json, on standard output")
      ->check(CLI::IsMember({"text", "json"}).description(""))
      ->option_text("FORMAT");
}

void AddColorFlag(CLI::App& command, EstimateFlags& flags) {
  command
      .add_flag("--color{mean}", flags.color,
                absl::StrCat("add columns red green blue for ", kQuantityWords,
                             ": --color=gaussian; alone: mean; with several --k at the largest"))
      ->check(CLI::IsMember({"mean", "gaussian", "k1", "k2"}).description(""));
}

// Fills in what several flags say together. Throws CLI::ValidationError if some contradict each other.
void ApplyFlags(const CLI::App& command, EstimateFlags& flags) {
  flags.given = OptionsText(command, WithoutEffect());
  ApplyQuantities(flags.quantities, flags.options);
  CheckColor(flags);
  CheckSource(flags.normals);
  ApplyScale(flags.scale, flags.options);
  CheckEstimatorFlags(command, flags.options);
  CheckConflicts(flags.options, flags.quantities);
  CheckNormalCount("normal-", flags.normals);
  if (flags.timeout > 0.0) flags.options.timeout = absl::Seconds(flags.timeout);
  flags.options.connect_timeout = absl::Seconds(flags.connect_timeout);
  if (flags.tiles) CheckEstimateInTiles(flags);
  if (flags.force && !IsDirectory(flags.output)) {
    throw CLI::ValidationError("--force", "needs a directory for --output, as results/");
  }
}

}  // namespace

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
  command
      .add_option("--regression-degree", flags.options.regression_degree,
                  "degree of normal-regression's polynomials, 1 to 3; 2 takes more noise away, 1 is for spheres, "
                  "cylinders and planes")
      ->check(Whole(1, 3))
      ->option_text("DEGREE [3]");
  command.add_flag("--even-weights", flags.options.even_weights,
                   "count all triangles of delaunay alike, as the paper does");
  command.add_flag(
      "--project", flags.options.project,
      "with aso: measure the fitted surface at the place nearest to the point, not its level through the point: for "
      "noisy positions; --k=auto always does");
  command.add_option("--seed", flags.options.seed, "of the random estimators")
      ->check(Whole(0, ~uint64_t{0}))
      ->option_text("NUMBER [0]");
  command
      .add_option_function<double>(
          "--average-normal-weight", [&flags](double weight) { flags.options.average_normal_weight = weight; },
          "weight of the neighborhood's mean normal, 0 to 1 [0.5]")
      ->check(UpTo(1.0))
      ->option_text("WEIGHT");
}

void CheckEstimatorFlags(const CLI::App& command, const EstimateOptions& options) {
  if (!AskForCurvature(options.quantities)) CheckNoneIsGiven(command);
  for (const auto& [name, estimators] : EstimatorFlags()) {
    const bool is_read = std::find(estimators.begin(), estimators.end(), options.estimator) != estimators.end();
    if (is_read || command.get_option(name)->count() == 0) continue;
    std::string words;
    for (const Estimator estimator : estimators) {
      absl::StrAppend(&words, words.empty() ? "" : " or ", std::string(EstimatorName(estimator)));
    }
    throw CLI::ValidationError(name, absl::StrCat("needs --estimator=", words, "; ",
                                                  std::string(EstimatorName(options.estimator)), " does not read it"));
  }
}

void AddInvalidFlag(CLI::App& command, EstimateFlags& flags) {
  command
      .add_option_function<std::string>(
          "--on-invalid", [&flags](const std::string& policy) { flags.options.skip_invalid = policy == "skip"; },
          "reject [default]: refuse a cloud with an unusable point; skip: give the point a status")
      ->check(CLI::IsMember({"reject", "skip"}).description(""))
      ->option_text("POLICY");
}

void AddEstimate(CLI::App& app, Action& action) {
  auto flags = std::make_shared<EstimateFlags>();
  CLI::App* command = app.add_subcommand("estimate", "Estimate the curvature of a point cloud");
  command->footer(absl::StrCat(kEstimateExamples, "\n", kExitCodesHelp));
  AddFileFlags(*command, *flags);
  AddServerFlags(*command, *flags);
  AddEstimatorFlags(*command, *flags);
  AddSourceFlags(*command, flags->normals);
  AddSideFlags(*command, flags->normals);
  AddMethodFlags(*command, "normal-", flags->normals);
  AddCallFlags(*command, *flags);
  AddInvalidFlag(*command, *flags);
  AddOpposedNormalsFlag(*command, *flags);
  AddSummaryFlag(*command, *flags);
  AddQuantityFlags(*command, flags->quantities);
  AddColorFlag(*command, *flags);
  command->callback([flags, command, &action] {
    ApplyFlags(*command, *flags);
    action = [flags] { return flags->tiles ? EstimateInTiles(*flags) : EstimateFiles(*flags); };
  });
}

}  // namespace curv
