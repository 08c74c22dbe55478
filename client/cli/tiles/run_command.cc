#include <cstdio>
#include <memory>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "client/cli/connection.h"
#include "client/cli/connection_flags.h"
#include "client/cli/flags.h"
#include "client/cli/interrupt.h"
#include "client/cli/json.h"
#include "client/cli/numbers.h"
#include "client/cli/tiles/tile_commands.h"
#include "client/cli/tiles/tile_options.h"
#include "client/cli/tiles/tile_steps.h"

namespace curv {
namespace {

constexpr char kRunHelp[] =
    "Any number of runs, on any machines that see the directory, share the tiles; what is done is done once. A run\n"
    "that was killed leaves nothing half done: start it again. Without --server, an own server takes the tiles.";

struct RunFlags {
  std::string directory;
  ConnectionFlags connection;
  int threads = 0;
  RunRequest request;
  uint64_t tile = 0;
  double connect_timeout = 1.5;
  double timeout = 0.0;
  int max_attempts = 6;
  std::string summary = "text";
};

double PercentOf(uint64_t part, uint64_t whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

void PrintOutcome(const RunOutcome& outcome, double seconds, bool json) {
  if (json) {
    std::fputs(ToJsonLine({{"tiles", outcome.tiles},
                           {"points", outcome.points},
                           {"halo_points", outcome.halo_points},
                           {"uncertain_points", outcome.uncertain_points},
                           {"repair_points", outcome.repair_points},
                           {"coarse_points", outcome.coarse_points},
                           {"tiles_with_opposed_normals", outcome.opposed_tiles},
                           {"tiles_with_normals_off_surface", outcome.off_surface_tiles},
                           {"seconds", seconds}})
                   .c_str(),
               stdout);
    return;
  }
  std::printf("%s with %s in %s", CountOf(outcome.tiles, "tile").c_str(), CountOf(outcome.points, "point").c_str(),
              Clock(seconds).c_str());
  if (outcome.points > 0) {
    std::printf("; halo %.1f %%", PercentOf(outcome.halo_points, outcome.points));
  }
  if (outcome.points > 0 && outcome.uncertain_points > 0) {
    std::printf("; %s estimated again, with %.2f %% of all points sent for that",
                CountOf(outcome.uncertain_points, "point").c_str(), PercentOf(outcome.repair_points, outcome.points));
  }
  std::printf("\n");
}

ExitCode Run(const RunFlags& flags) {
  const absl::StatusOr<TilePlan> plan = LoadPlan(flags.directory);
  if (!plan.ok()) return FailTiles(plan.status());
  absl::StatusOr<EstimateOptions> options = OptionsOf(plan->options);
  if (!options.ok()) {
    return Fail(ExitCode::kInput, absl::StrCat(plan->PathOf("plan.json"), ": ", options.status().message()));
  }
  options->priority = Priority::kBatch;
  options->connect_timeout = absl::Seconds(flags.connect_timeout);
  if (flags.timeout > 0.0) options->timeout = absl::Seconds(flags.timeout);
  options->max_attempts = flags.max_attempts;
  const InterruptWatch interrupt;
  const absl::StatusOr<std::unique_ptr<Connection>> connection = Connection::Create(flags.connection, flags.threads);
  if (!connection.ok()) return Fail(ExitCode::kUsage, connection.status());
  const absl::Time start = absl::Now();
  const absl::StatusOr<RunOutcome> outcome =
      RunWithProgress(*plan, flags.request, **connection, *options, interrupt.token());
  if (!outcome.ok()) return FailTiles(outcome.status());
  PrintOutcome(*outcome, absl::ToDoubleSeconds(absl::Now() - start), flags.summary == "json");
  return ExitCode::kOk;
}

}  // namespace

void AddTilesRun(CLI::App& tiles, Action& action) {
  auto flags = std::make_shared<RunFlags>();
  CLI::App* command = tiles.add_subcommand("run", "Estimate the tiles of a plan that are not done");
  command->footer(absl::StrCat(kRunHelp, "\n", kExitCodesHelp));
  AddPlanDirectory(*command, flags->directory);
  CLI::Option* tile = command->add_option("--tile", flags->tile, "this tile alone, counted from 0 [all that are left]")
                          ->check(Whole(0, ~uint64_t{0}))
                          ->option_text("NUMBER");
  AddConnectionFlags(*command, flags->connection);
  command->add_option("--threads", flags->threads, "workers without --server; 0 [default]: one a core")
      ->check(Whole(0, 1024))
      ->excludes(command->get_option("--server"))
      ->option_text("COUNT");
  command
      ->add_option("--jobs", flags->request.jobs, "tiles at a time, so that one is read while another is estimated [2]")
      ->check(Whole(1, 1024))
      ->option_text("COUNT");
  command
      ->add_option(
          "--halo", flags->request.halo_factor,
          "how wide the rim around a tile is, in radii of the neighborhoods there. Changes the time alone: where it "
          "is too narrow, points are estimated again [1.25]")
      ->check(FiniteNotNegative())
      ->option_text("FACTOR");
  command
      ->add_option("--connect-timeout", flags->connect_timeout,
                   "seconds until it is given up if no server answers at all [1.5]")
      ->check(FinitePositive())
      ->option_text("SECONDS");
  command->add_option("--timeout", flags->timeout, "seconds until a tile's call is given up [none]")
      ->check(FinitePositive())
      ->option_text("SECONDS");
  command->add_option("--max-attempts", flags->max_attempts, "times a tile is sent if servers are unavailable")
      ->check(Whole(1, 100))
      ->option_text("COUNT [6]");
  command->add_option("--summary", flags->summary, "text [default] or json, on standard output")
      ->check(CLI::IsMember({"text", "json"}).description(""))
      ->option_text("FORMAT");
  command->callback([flags, tile, &action] {
    if (tile->count() > 0) flags->request.tile = flags->tile;
    action = [flags] { return Run(*flags); };
  });
}

}  // namespace curv
