#include "client/cli/tiles/tile_commands.h"

#include "absl/strings/str_cat.h"
#include "client/cli/flags.h"
#include "client/cli/tiles/tile_calls.h"

namespace curv {
namespace {

constexpr char kTilesExamples[] =
    "Examples:\n"
    "  curv tiles plan country/*.las -o work --k=50                        once\n"
    "  curv tiles run work --server=a:50061,b:50061                       here, or on many machines that see the "
    "files\n"
    "  curv tiles status work\n"
    "  curv tiles merge work -o curvature.ply\n"
    "A run that was interrupted goes on where it ended. docs/scale.md tells what is promised.";

}  // namespace

void AddPlanDirectory(CLI::App& command, std::string& directory) {
  command.add_option("directory", directory, "the directory of the plan")
      ->required()
      ->check(NotEmpty())
      ->option_text("DIR");
}

ExitCode FailTiles(const absl::Status& status) {
  if (IsServerError(status)) return FailCall(status);
  switch (status.code()) {
    case absl::StatusCode::kDataLoss:
      return Fail(ExitCode::kOutput, status);
    case absl::StatusCode::kCancelled:
      return Fail(ExitCode::kInterrupted, "interrupted");
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kNotFound:
      return Fail(ExitCode::kUsage, status);
    case absl::StatusCode::kInternal:
      return Fail(ExitCode::kFailed, status);
    default:
      return Fail(ExitCode::kInput, status);
  }
}

void AddTiles(CLI::App& app, Action& action) {
  CLI::App* tiles = app.add_subcommand("tiles", "Estimate clouds larger than memory, in tiles that leave no seam");
  tiles->footer(absl::StrCat(kTilesExamples, "\n", kExitCodesHelp));
  tiles->require_subcommand(1);
  AddTilesPlan(*tiles, action);
  AddTilesRun(*tiles, action);
  AddTilesStatus(*tiles, action);
  AddTilesMerge(*tiles, action);
  AddTilesVerify(*tiles, action);
}

}  // namespace curv
