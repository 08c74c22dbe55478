#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "client/cli/command.h"
#include "client/cli/files/format_flags.h"
#include "client/cli/files/kept_inputs.h"
#include "client/cli/files/save_output.h"
#include "client/cli/interrupt.h"
#include "client/cli/numbers.h"
#include "client/cli/select/condition.h"
#include "client/io/table_file.h"

namespace curv {
namespace {

constexpr char kSelectExamples[] =
    "Examples:\n"
    "  curv select result.ply --where 'k2 > 0.5 and status == ok' -o edges.ply\n"
    "  curv select result.las --where 'classification == 2 and abs(mean_curvature) < 0.1' -o ground.las\n"
    "  curv select result.ply --where 'not (status == ok)' -o failed.csv\n"
    "Conditions compare (< <= > >= == !=) columns, numbers, and what + - * / and abs() make of them; and, or, not and\n"
    "parentheses join them. Words of status are ok, too_few_neighbors, degenerate_area, invalid_input,\n"
    "inconsistent_normals, singular_fit, opposed_normals and outlier. Names with blanks stand in double quotes.";

struct SelectFlags {
  std::string input;
  std::string output;
  std::string where;
  std::string input_format;
  SaveOptions save;
};

ExitCode Run(const SelectFlags& flags) {
  if (const ExitCode code = CheckOutput(flags.output, flags.save); code != ExitCode::kOk) return code;
  if (absl::Status status = KeptInputs({flags.input}).Check(flags.output); !status.ok())
    return Fail(ExitCode::kUsage, status);
  const absl::StatusOr<PointTable> table = LoadTable(flags.input, flags.input_format);
  if (!table.ok()) return Fail(ExitCode::kInput, table.status());
  for (const std::string& note : table->notes) PrintNote(absl::StrCat(flags.input, ": ", note));
  const absl::StatusOr<Condition> condition = Condition::Parse(flags.where, *table);
  if (absl::IsNotFound(condition.status())) {
    return Fail(ExitCode::kInput, absl::StrCat(flags.input, ": --where: ", condition.status().message()));
  }
  if (!condition.ok()) return Fail(ExitCode::kUsage, absl::StrCat("--where: ", condition.status().message()));
  const std::vector<size_t> rows = condition->Rows();
  if (rows.empty()) {
    return Fail(ExitCode::kFailed, absl::StrCat("the condition holds for none of ", CountOf(table->size(), "point"),
                                                ": nothing was written"));
  }
  const UninterruptedWrite write(flags.output);
  const absl::Status saved = SaveOutput(SelectRows(*table, rows), flags.output, flags.save);
  if (!saved.ok()) return Fail(ExitCode::kOutput, saved);
  std::fprintf(SummaryStream(flags.output), "%s: %s of %s\n", ShownOutput(flags.output).c_str(),
               WithCommas(rows.size()).c_str(), CountOf(table->size(), "point").c_str());
  return ExitCode::kOk;
}

}  // namespace

void AddSelect(CLI::App& app, Action& action) {
  auto flags = std::make_shared<SelectFlags>();
  CLI::App* command = app.add_subcommand("select", "Keep the points for which a condition on their columns holds");
  command->footer(absl::StrCat(kSelectExamples, "\n", kExitCodesHelp));
  command->add_option("input", flags->input, absl::StrCat("a result, or any cloud: ", kReadableFiles))
      ->required()
      ->option_text("RESULT");
  command->add_option("--where", flags->where, "the condition, as \"k2 > 0.5 and status == ok\"")
      ->required()
      ->option_text("CONDITION");
  AddOutput(*command, flags->output, absl::StrCat("the points: ", kWritableFiles));
  AddFormats(*command, flags->input_format, flags->save);
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
