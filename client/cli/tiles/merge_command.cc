#include <cstdio>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/cli/files/format_flags.h"
#include "client/cli/interrupt.h"
#include "client/cli/numbers.h"
#include "client/cli/tiles/tile_commands.h"
#include "client/cli/tiles/tile_steps.h"
#include "client/io/table_file.h"

namespace curv {
namespace {

struct MergeFlags {
  std::string directory;
  std::string output;
  SaveOptions save;
};

ExitCode Run(const MergeFlags& flags) {
  const absl::Status writable = CheckWritable(flags.output, flags.save);
  if (!writable.ok()) return Fail(ExitCode::kOutput, writable);
  const absl::StatusOr<TilePlan> plan = LoadPlan(flags.directory);
  if (!plan.ok()) return FailTiles(plan.status());
  const InterruptWatch interrupt;
  const absl::Status status = MergeWithProgress(*plan, flags.output, flags.save, interrupt.token());
  if (!status.ok()) return FailTiles(status);
  std::fprintf(SummaryStream(flags.output), "%s: %s\n", ShownOutput(flags.output).c_str(),
               CountOf(plan->points, "point").c_str());
  return ExitCode::kOk;
}

}  // namespace

void AddTilesMerge(CLI::App& tiles, Action& action) {
  auto flags = std::make_shared<MergeFlags>();
  CLI::App* command = tiles.add_subcommand("merge", "Write the points of a plan with their results, in their order");
  command->footer(kExitCodesHelp);
  AddPlanDirectory(*command, flags->directory);
  command
      ->add_option("-o,--output", flags->output,
                   absl::StrCat("the result: ", kWritableFiles, ". .las and .npz as far as memory goes"))
      ->required()
      ->option_text("OUT");
  AddFormatFlags(*command, flags->save);
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
