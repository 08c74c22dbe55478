#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/cli/estimate_summary.h"
#include "client/cli/files/format_flags.h"
#include "client/cli/files/kept_inputs.h"
#include "client/cli/files/save_output.h"
#include "client/cli/interrupt.h"
#include "client/cli/json.h"
#include "client/cli/numbers.h"
#include "client/cli/tiles/tile_commands.h"
#include "client/cli/tiles/tile_steps.h"
#include "client/io/atomic_file.h"
#include "client/io/table_file.h"

namespace curv {
namespace {

struct MergeFlags {
  std::string directory;
  std::string output;
  SaveOptions save;
  std::string summary = "text";
};

void PrintSummary(const MergeFlags& flags, const TilePlan& plan, const StatusCounts& counts) {
  if (flags.summary == "json") {
    const auto json = ToJsonLine({{"directory", flags.directory},
                                  {"output", flags.output},
                                  {"points", plan.points},
                                  {"status", StatusJson(counts)}});
    std::fputs(json.c_str(), SummaryStream(flags.output));
    return;
  }
  std::fprintf(SummaryStream(flags.output), "%s: %s\n%s", ShownOutput(flags.output).c_str(),
               CountOf(plan.points, "point").c_str(), StatusText(counts).c_str());
}

ExitCode Run(const MergeFlags& flags) {
  if (const ExitCode code = CheckOutput(flags.output, flags.save); code != ExitCode::kOk) return code;
  const absl::StatusOr<TilePlan> plan = LoadPlan(flags.directory);
  if (!plan.ok()) return FailTiles(plan.status());
  std::vector<std::string> inputs;
  for (const TileInput& input : plan->inputs) inputs.push_back(input.path);
  if (absl::Status status = KeptInputs(inputs).Check(flags.output); !status.ok()) return Fail(ExitCode::kUsage, status);
  const InterruptWatch interrupt;
  const InterruptWatch::EndsAtOnce at_once(interrupt, IsWrittenDirectly(flags.output));
  const absl::StatusOr<StatusCounts> counts = MergeWithProgress(*plan, flags.output, flags.save, interrupt.token());
  if (!counts.ok()) return FailTiles(counts.status());
  PrintSummary(flags, *plan, *counts);
  return ExitCode::kOk;
}

}  // namespace

void AddTilesMerge(CLI::App& tiles, Action& action) {
  auto flags = std::make_shared<MergeFlags>();
  CLI::App* command = tiles.add_subcommand("merge", "Write the points of a plan with their results, in their order");
  command->footer(kExitCodesHelp);
  AddPlanDirectory(*command, flags->directory);
  AddOutput(*command, flags->output,
            absl::StrCat("the result: ", kWritableFiles, ". .las and .npz as far as memory goes"));
  AddOutputFormat(*command, flags->save);
  command->add_option("--summary", flags->summary, "text [default] or json, on standard output")
      ->check(CLI::IsMember({"text", "json"}).description(""))
      ->option_text("FORMAT");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
