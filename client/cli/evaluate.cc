#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

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

std::string Text(const std::string& input, const Accuracy& accuracy) {
  std::string text = absl::StrFormat("%s: %s of %s points compared with the truth\n", ShownInput(input),
                                     WithCommas(accuracy.compared), WithCommas(accuracy.points));
  absl::StrAppendFormat(&text, "  %-22s %14s %14s %14s\n", "absolute error", "mean", "RMS", "largest");
  for (const QuantityError& error : accuracy.errors) {
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

std::string Json(const std::string& input, const Accuracy& accuracy) {
  nlohmann::ordered_json errors = nlohmann::ordered_json::object();
  for (const QuantityError& error : accuracy.errors) {
    errors[error.quantity] = {{"mean", error.mean}, {"rms", error.rms}, {"max", error.largest}};
  }
  const auto angle = [](const std::optional<double>& degrees) {
    return degrees ? nlohmann::ordered_json(*degrees) : nlohmann::ordered_json(nullptr);
  };
  return ToJsonLine({{"input", input},
                     {"points", accuracy.points},
                     {"compared", accuracy.compared},
                     {"errors", std::move(errors)},
                     {"median_angle_degrees", {{"d1", angle(accuracy.d1_angle)}, {"d2", angle(accuracy.d2_angle)}}}});
}

ExitCode Run(const EvaluateFlags& flags) {
  absl::StatusOr<PointTable> table = LoadTable(flags.input, flags.format);
  if (!table.ok()) return Fail(ExitCode::kInput, table.status());
  absl::StatusOr<Accuracy> accuracy = MeasureAccuracy(*table);
  if (!accuracy.ok()) return Fail(ExitCode::kInput, absl::StrCat(flags.input, ": ", accuracy.status().message()));
  std::fputs((flags.json ? Json(flags.input, *accuracy) : Visible(Text(flags.input, *accuracy))).c_str(), stdout);
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
