#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/flags.h"
#include "client/cli/json.h"
#include "client/cli/numbers.h"
#include "client/cli/tiles/tile_commands.h"
#include "client/io/atomic_file.h"
#include "client/tiles/tile_status.h"

namespace curv {
namespace {

struct StatusFlags {
  std::string directory;
  bool json = false;
  bool left = false;
  std::string prometheus;
};

std::string TextOf(const TilePlan& plan, const TileStatus& status) {
  const auto row = [](const char* name, const std::string& value, const std::string& more = "") {
    return absl::StrFormat("%-12s %16s%s\n", name, value, more.empty() ? "" : "  " + more);
  };
  const auto percent = [](uint64_t part, uint64_t whole) {
    return whole == 0 ? "" : absl::StrFormat("%.4g %%", 100.0 * static_cast<double>(part) / static_cast<double>(whole));
  };
  std::string text = absl::StrCat(plan.directory, ": ", plan.options.dump(), "\n");
  absl::StrAppend(
      &text, row("points", WithCommas(status.points)), row("tiles", WithCommas(status.tiles)),
      row("done", WithCommas(status.tiles_done), percent(status.points_done, status.points) + " of the points"),
      row("running", WithCommas(status.tiles_running)));
  if (status.tiles_damaged > 0) {
    absl::StrAppend(&text, row("damaged", WithCommas(status.tiles_damaged), "they are done again"));
  }
  absl::StrAppend(&text, row("halo", WithCommas(status.halo_points), percent(status.halo_points, status.points_done)));
  if (status.uncertain_points > 0) {
    const std::string sent = percent(status.repair_points, status.points_done);
    absl::StrAppend(&text, row("repaired", WithCommas(status.uncertain_points),
                               absl::StrCat("estimated again, with ", sent, " of all points sent for that")));
  }
  if (status.coarse_points > 0) {
    absl::StrAppend(&text, row("coarse", WithCommas(status.coarse_points), "too far from others for the lattice"));
  }
  if (status.opposed_tiles > 0) {
    absl::StrAppend(&text, row("opposed", WithCommas(status.opposed_tiles),
                               "tiles whose normals point to both sides of one surface: run curv orient before"));
  }
  if (status.off_surface_tiles > 0) {
    absl::StrAppend(&text, row("off", WithCommas(status.off_surface_tiles),
                               "tiles whose normals do not fit the positions: run curv normals before"));
  }
  if (status.points_per_second > 0.0) {
    absl::StrAppend(&text, row("rate", WithPrefix(status.points_per_second), "points/s"));
  }
  if (status.seconds_left.has_value()) absl::StrAppend(&text, row("ETA", Clock(*status.seconds_left)));
  if (status.is_complete()) {
    absl::StrAppend(&text, "complete: curv tiles merge ", ShellWord(plan.directory), " -o OUT\n");
  } else if (status.tiles_running == 0) {
    absl::StrAppend(&text, "nobody works: curv tiles run ", ShellWord(plan.directory), "\n");
  }
  return text;
}

std::string JsonOf(const TilePlan& plan, const TileStatus& status) {
  nlohmann::ordered_json json = {{"directory", plan.directory},
                                 {"plan", plan.id},
                                 {"tiles", status.tiles},
                                 {"tiles_done", status.tiles_done},
                                 {"tiles_running", status.tiles_running},
                                 {"tiles_damaged", status.tiles_damaged},
                                 {"points", status.points},
                                 {"points_done", status.points_done},
                                 {"halo_points", status.halo_points},
                                 {"uncertain_points", status.uncertain_points},
                                 {"repair_points", status.repair_points},
                                 {"coarse_points", status.coarse_points},
                                 {"tiles_with_opposed_normals", status.opposed_tiles},
                                 {"tiles_with_normals_off_surface", status.off_surface_tiles},
                                 {"work_seconds", status.work_seconds},
                                 {"points_per_second", status.points_per_second},
                                 {"seconds_left", nullptr},
                                 {"complete", status.is_complete()}};
  if (status.seconds_left.has_value()) json["seconds_left"] = *status.seconds_left;
  return ToJsonLine(json);
}

// For the textfile collector of node_exporter.
std::string PrometheusOf(const TilePlan& plan, const TileStatus& status) {
  const std::string labels = absl::StrCat("{plan=\"", plan.id, "\"} ");
  std::string text;
  const auto gauge = [&](const char* name, const char* help, double value) {
    absl::StrAppend(&text, "# HELP ", name, " ", help, "\n# TYPE ", name, " gauge\n", name, labels,
                    absl::StrFormat("%.17g", value), "\n");
  };
  gauge("curv_tiles", "Tiles of the plan.", static_cast<double>(status.tiles));
  gauge("curv_tiles_done", "Tiles that are done.", static_cast<double>(status.tiles_done));
  gauge("curv_tiles_running", "Tiles that somebody has at hand.", static_cast<double>(status.tiles_running));
  gauge("curv_tiles_damaged", "Tiles whose file is no result.", static_cast<double>(status.tiles_damaged));
  gauge("curv_tiles_points", "Points in tiles.", static_cast<double>(status.points));
  gauge("curv_tiles_points_done", "Points in tiles that are done.", static_cast<double>(status.points_done));
  gauge("curv_tiles_repaired_points", "Points that were estimated again.",
        static_cast<double>(status.uncertain_points));
  gauge("curv_tiles_work_seconds", "Time that the tiles took, one after the other.", status.work_seconds);
  return text;
}

// One a line.
std::string NumbersOf(const std::vector<size_t>& tiles) {
  std::string text;
  for (const size_t tile : tiles) absl::StrAppend(&text, tile, "\n");
  return text;
}

ExitCode Run(const StatusFlags& flags) {
  const absl::StatusOr<TilePlan> plan = LoadPlan(flags.directory);
  if (!plan.ok()) return FailTiles(plan.status());
  const TileStatus status = StatusOf(*plan);
  if (!flags.prometheus.empty()) {
    absl::StatusOr<AtomicFile> file = AtomicFile::Create(flags.prometheus);
    absl::Status written = file.status();
    if (written.ok()) written = file->Append(PrometheusOf(*plan, status));
    if (written.ok()) written = file->Commit();
    if (!written.ok()) return Fail(ExitCode::kOutput, written);
    if (!flags.json && !flags.left) return ExitCode::kOk;
  }
  const std::string text = flags.left   ? NumbersOf(status.tiles_left)
                           : flags.json ? JsonOf(*plan, status)
                                        : TextOf(*plan, status);
  std::fputs(text.c_str(), stdout);
  return ExitCode::kOk;
}

}  // namespace

void AddTilesStatus(CLI::App& tiles, Action& action) {
  auto flags = std::make_shared<StatusFlags>();
  CLI::App* command = tiles.add_subcommand("status", "Tell how far the tiles of a plan are");
  command->footer(kExitCodesHelp);
  AddPlanDirectory(*command, flags->directory);
  CLI::Option* json = command->add_flag("--json", flags->json, "one line of JSON");
  command->add_flag("--left", flags->left, "the numbers of the tiles that are not done, one a line, for --tile of run")
      ->excludes(json);
  command
      ->add_option("--prometheus", flags->prometheus,
                   "write metrics into a file, for the textfile collector of node_exporter; - is standard output")
      ->check(NotEmpty())
      ->option_text("OUT");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
