#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/accuracy.h"
#include "client/cli/command.h"
#include "client/cli/files/format_flags.h"
#include "client/cli/flags.h"
#include "client/cli/json.h"
#include "client/cli/numbers.h"
#include "client/io/table_file.h"

namespace curv {
namespace {

constexpr char kEvaluateExamples[] =
    "Example:\n"
    "  curv generate torus --points=50000 -o torus.ply\n"
    "  curv estimate torus.ply -o result.ply\n"
    "  curv evaluate result.ply";

struct EvaluateFlags {
  std::string input;
  bool json = false;
  std::string format;
};

// Estimates at one number of neighbors, or at the only one there is.
struct ScaleAccuracy {
  std::string suffix;  // of their columns
  Accuracy accuracy;

  // "16" of "_k16".
  std::string NeighborCount() const { return suffix.substr(2); }
};

absl::StatusOr<std::vector<ScaleAccuracy>> MeasureAll(const PointTable& table) {
  std::vector<std::string> suffixes = EstimateSuffixes(table);
  if (suffixes.empty()) suffixes.emplace_back();  // for the error
  std::vector<ScaleAccuracy> scales;
  for (const std::string& suffix : suffixes) {
    absl::StatusOr<Accuracy> accuracy = MeasureAccuracy(table, suffix);
    if (!accuracy.ok()) return accuracy.status();
    scales.push_back({suffix, *std::move(accuracy)});
  }
  return scales;
}

std::string Text(const std::string& input, const ScaleAccuracy& scale) {
  const Accuracy& accuracy = scale.accuracy;
  std::string text = absl::StrFormat("%s%s: %s of %s compared with the truth\n", ShownInput(input),
                                     scale.suffix.empty() ? "" : absl::StrCat(", K = ", scale.NeighborCount()),
                                     WithCommas(accuracy.compared), CountOf(accuracy.points, "point"));
  if (accuracy.compared == 0) {
    return absl::StrCat(text, "  nothing to compare: no point is ok and has finite values\n");
  }
  absl::StrAppendFormat(&text, "  %-22s %14s %14s %14s\n", "absolute error", "mean", "RMS", "largest");
  for (const QuantityError& error : accuracy.errors) {
    if (std::isnan(error.mean)) {
      absl::StrAppendFormat(&text, "  %-22s %14s %14s %14s\n", error.quantity, "none", "none", "none");
      continue;
    }
    absl::StrAppendFormat(&text, "  %-22s %14.6g %14.6g %14.6g\n", error.quantity, error.mean, error.rms,
                          error.largest);
  }
  const auto angle = [](const std::optional<double>& degrees) {
    return degrees ? absl::StrFormat("%.3f degrees", *degrees) : std::string("none");
  };
  absl::StrAppendFormat(&text, "  median angle to the true directions: d1 %s, d2 %s\n", angle(accuracy.d1_angle),
                        angle(accuracy.d2_angle));
  return text;
}

// Adds what was compared, and how far it is off.
void AddJson(const Accuracy& accuracy, nlohmann::ordered_json& json) {
  nlohmann::ordered_json errors = nlohmann::ordered_json::object();
  for (const QuantityError& error : accuracy.errors) {
    errors[error.quantity] = {{"mean", error.mean}, {"rms", error.rms}, {"max", error.largest}};
  }
  const auto angle = [](const std::optional<double>& degrees) {
    return degrees ? nlohmann::ordered_json(*degrees) : nlohmann::ordered_json(nullptr);
  };
  json["compared"] = accuracy.compared;
  json["errors"] = std::move(errors);
  json["median_angle_degrees"] = {{"d1", angle(accuracy.d1_angle)}, {"d2", angle(accuracy.d2_angle)}};
}

std::string Json(const std::string& input, const std::vector<ScaleAccuracy>& scales) {
  nlohmann::ordered_json json = {{"input", input}, {"points", scales.front().accuracy.points}};
  nlohmann::ordered_json of_counts = nlohmann::ordered_json::array();
  for (const ScaleAccuracy& scale : scales) {
    if (scale.suffix.empty()) {
      AddJson(scale.accuracy, json);
      continue;
    }
    nlohmann::ordered_json of_count = {{"neighbor_count", std::stoull(scale.NeighborCount())}};
    AddJson(scale.accuracy, of_count);
    of_counts.push_back(std::move(of_count));
  }
  if (!of_counts.empty()) json["scales"] = std::move(of_counts);
  return ToJsonLine(json);
}

ExitCode Run(const EvaluateFlags& flags) {
  absl::StatusOr<PointTable> table = LoadTable(flags.input, flags.format);
  if (!table.ok()) return Fail(ExitCode::kInput, table.status());
  const absl::StatusOr<std::vector<ScaleAccuracy>> scales = MeasureAll(*table);
  if (!scales.ok()) return Fail(ExitCode::kInput, absl::StrCat(flags.input, ": ", scales.status().message()));
  if (flags.json) {
    std::fputs(Json(flags.input, *scales).c_str(), stdout);
    return ExitCode::kOk;
  }
  for (const ScaleAccuracy& scale : *scales) std::fputs(Text(flags.input, scale).c_str(), stdout);
  return ExitCode::kOk;
}

}  // namespace

void AddEvaluate(CLI::App& app, Action& action) {
  auto flags = std::make_shared<EvaluateFlags>();
  CLI::App* command = app.add_subcommand("evaluate", "Compare a result with the exact curvature that it carries");
  command->footer(absl::StrCat(kEvaluateExamples, "\n", kExitCodesHelp));
  command->add_option("result", flags->input, "a result of curv estimate with true_* columns")
      ->required()
      ->option_text("RESULT");
  AddInputFormat(*command, flags->format);
  command->add_flag("--json", flags->json, "one line of JSON instead of a table");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
