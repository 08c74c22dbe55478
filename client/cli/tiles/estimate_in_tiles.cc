#include "client/cli/tiles/estimate_in_tiles.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client/cli/connection.h"
#include "client/cli/estimate_summary.h"
#include "client/cli/files/batch.h"
#include "client/cli/files/kept_inputs.h"
#include "client/cli/files/save_output.h"
#include "client/cli/interrupt.h"
#include "client/cli/json.h"
#include "client/cli/numbers.h"
#include "client/cli/tiles/tile_checks.h"
#include "client/cli/tiles/tile_commands.h"
#include "client/cli/tiles/tile_options.h"
#include "client/cli/tiles/tile_steps.h"
#include "client/io/atomic_file.h"
#include "client/io/blocks/input_file.h"
#include "client/io/table_file.h"

namespace curv {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kTilePoints = 350'000;
constexpr uint64_t kLeastTilePoints = 100;
// A server takes a tile of this part of its limit, with what goes along: the halo is at most four tiles.
constexpr uint64_t kPartOfLimit = 6;

// One file on its way through the steps.
class TiledEstimate {
 public:
  explicit TiledEstimate(const EstimateFlags& flags) : flags_(flags), options_(flags.options) {
    directory_ = flags.tiles_directory.empty() ? flags.output + ".tiles" : flags.tiles_directory;
    if (options_.priority == Priority::kBySize) options_.priority = Priority::kBatch;
  }

  ExitCode Run() {
    const absl::Time start = absl::Now();
    if (const ExitCode code = CheckOutput(flags_.output, flags_.save); code != ExitCode::kOk) return code;
    if (absl::Status status = KeptInputs(flags_.inputs).Check(flags_.output); !status.ok())
      return Fail(ExitCode::kUsage, status);
    absl::StatusOr<std::unique_ptr<Connection>> connection = Connection::Create(flags_.connection, flags_.threads);
    if (!connection.ok()) return Fail(ExitCode::kUsage, connection.status());
    const absl::StatusOr<ServerInfo> server = (*connection)->client().GetServerInfo(options_.connect_timeout);
    if (!server.ok()) return FailCall(server.status());
    if (const ExitCode code = FindOrMakePlan(server->max_points); code != ExitCode::kOk) return code;
    const absl::StatusOr<RunOutcome> outcome =
        RunWithProgress(plan_, RunRequest(), **connection, options_, interrupt_.token());
    const absl::StatusOr<StatusCounts> counts = outcome.ok() ? Merge() : absl::StatusOr<StatusCounts>(outcome.status());
    if (!counts.ok()) {
      const ExitCode code = FailTiles(counts.status());
      PrintNote(absl::StrCat("the tiles that are done are in ", directory_, ": the same command goes on with them"));
      return code;
    }
    if (const absl::Status removed = RemovePlan(plan_); !removed.ok()) PrintWarning(std::string(removed.message()));
    PrintSummary(*outcome, *counts, absl::ToDoubleSeconds(absl::Now() - start));
    return ExitCode::kOk;
  }

 private:
  ExitCode FindOrMakePlan(uint64_t max_points) {
    std::error_code error;
    if (fs::exists(fs::path(directory_) / "plan.json", error)) {
      const absl::Status status = TakeUpPlan();
      return status.ok() ? ExitCode::kOk : Fail(ExitCode::kUsage, status);
    }
    if (fs::exists(directory_, error) && !fs::is_empty(directory_, error)) {
      return Fail(ExitCode::kUsage, absl::StrCat(directory_,
                                                 " holds other things than tiles: name another directory "
                                                 "with --tiles-directory"));
    }
    const absl::StatusOr<TileReach> reach = ReachOf(options_);
    if (!reach.ok()) return Fail(ExitCode::kUsage, reach.status());
    PlanRequest request;
    request.inputs = flags_.inputs;
    request.format = flags_.input_format;
    request.directory = directory_;
    request.tile_points = std::clamp(max_points / kPartOfLimit, kLeastTilePoints, kTilePoints);
    request.skip_invalid = options_.skip_invalid;
    request.reach = *reach;
    request.options = JsonOf(options_);
    absl::StatusOr<PlanOutcome> outcome = PlanWithProgress(request, interrupt_.token());
    if (!outcome.ok()) {
      fs::remove_all(directory_, error);  // nothing in it is of use
      return FailTiles(outcome.status());
    }
    for (const std::string& note : outcome->notes) PrintNote(note);
    plan_ = std::move(outcome->plan);
    if (plan_.is_double) {
      PrintNote(absl::StrCat("coordinates in doubles are rounded to multiples of ", ExactText(plan_.spacing)));
    }
    return ExitCode::kOk;
  }

  absl::StatusOr<StatusCounts> Merge() const {
    const InterruptWatch::EndsAtOnce at_once(interrupt_, IsWrittenDirectly(flags_.output));
    return MergeWithProgress(plan_, flags_.output, flags_.save, interrupt_.token());
  }

  // Goes on with the plan that is there, if it is of this file and these options.
  absl::Status TakeUpPlan() {
    absl::StatusOr<TilePlan> plan = LoadPlan(directory_);
    if (!plan.ok()) return plan.status();
    const absl::StatusOr<InputFile> input = InputFile::Open(flags_.inputs.front());
    if (!input.ok()) return input.status();
    std::error_code error;
    const std::string path = fs::canonical(flags_.inputs.front(), error).string();
    const bool is_same = plan->inputs.size() == 1 && plan->inputs[0].path == path &&
                         plan->inputs[0].format == flags_.input_format && plan->inputs[0].stamp == input->stamp() &&
                         plan->options == JsonOf(options_);
    if (!is_same) {
      return absl::AlreadyExistsError(
          absl::StrCat(directory_,
                       " has tiles of another file, or with other options: remove it, or name another directory with "
                       "--tiles-directory"));
    }
    PrintNote(absl::StrCat("goes on with the tiles in ", directory_));
    plan_ = *std::move(plan);
    return absl::OkStatus();
  }

  void PrintSummary(const RunOutcome& outcome, const StatusCounts& counts, double seconds) const {
    if (flags_.summary == "json") {
      std::fputs(ToJsonLine({{"input", flags_.inputs.front()},
                             {"output", flags_.output},
                             {"server", flags_.connection.server.empty() ? "embedded" : flags_.connection.server},
                             {"points", plan_.points},
                             {"unusable_points", plan_.unusable},
                             {"status", StatusJson(counts)},
                             {"tiles", plan_.tiles.size()},
                             {"tiles_done_before", plan_.tiles.size() - outcome.tiles},
                             {"halo_points", outcome.halo_points},
                             {"uncertain_points", outcome.uncertain_points},
                             {"repair_points", outcome.repair_points},
                             {"spacing", plan_.spacing},
                             {"seconds", seconds}})
                     .c_str(),
                 stdout);
      return;
    }
    std::printf("%s: %s in %s, %s\n%s  wrote %s\n", Visible(flags_.inputs.front()).c_str(),
                CountOf(plan_.points, "point").c_str(), CountOf(plan_.tiles.size(), "tile").c_str(),
                Clock(seconds).c_str(), StatusText(counts).c_str(), ShownOutput(flags_.output).c_str());
  }

  const EstimateFlags& flags_;
  EstimateOptions options_;
  std::string directory_;
  const InterruptWatch interrupt_;
  TilePlan plan_;
};

}  // namespace

void CheckEstimateInTiles(const EstimateFlags& flags) {
  const auto refuse = [](const char* flag, const std::string& why) { throw CLI::ValidationError(flag, why); };
  if (flags.inputs.size() != 1 || IsDirectory(flags.output)) {
    refuse("--tiles", "takes one file for one output; curv tiles plan takes many, which then count as one cloud");
  }
  if (flags.inputs.front() == "-") refuse("--tiles", "standard input cannot be read twice: write it into a file first");
  if (flags.output == "-") refuse("--tiles", "the result goes to a file, beside which the tiles are kept");
  CheckTileNormals(flags.normals);
  CheckTileQuantities(flags.quantities);
  if (!flags.color.empty()) refuse("--color", "colors follow from the values of the whole cloud, which no tile has");
  if (flags.options.reject_opposed_normals) {
    refuse("--on-opposed-normals", "which normals are opposed follows from the whole cloud, which no tile has");
  }
  const absl::StatusOr<TileReach> reach = ReachOf(flags.options);
  if (!reach.ok()) refuse("--tiles", std::string(reach.status().message()));
}

ExitCode EstimateInTiles(const EstimateFlags& flags) { return TiledEstimate(flags).Run(); }

}  // namespace curv
