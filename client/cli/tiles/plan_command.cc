#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "client/cli/estimate_flags.h"
#include "client/cli/files/format_flags.h"
#include "client/cli/flags.h"
#include "client/cli/interrupt.h"
#include "client/cli/json.h"
#include "client/cli/numbers.h"
#include "client/cli/tiles/tile_checks.h"
#include "client/cli/tiles/tile_commands.h"
#include "client/cli/tiles/tile_options.h"
#include "client/cli/tiles/tile_steps.h"
#include "client/io/table_file.h"
#include "client/tiles/plan_tiles.h"

namespace curv {
namespace {

constexpr uint64_t kLeastMemory = 16 << 20;

struct PlanFlags {
  EstimateFlags estimate;
  PlanRequest request;
  double lattice = 0.0;
  std::string summary = "text";
};

void PrintPlan(const TilePlan& plan, bool json) {
  uint64_t largest = 0;
  for (size_t tile = 0; tile < plan.tiles.size(); ++tile) largest = std::max(largest, plan.tile(tile).count);
  if (json) {
    std::fputs(ToJsonLine({{"directory", plan.directory},
                           {"points", plan.points},
                           {"unusable_points", plan.unusable},
                           {"tiles", plan.tiles.size()},
                           {"largest_tile_points", largest},
                           {"spacing", plan.spacing}})
                   .c_str(),
               stdout);
    return;
  }
  std::printf("%s: %s in %s of up to %s\n", Visible(plan.directory).c_str(), CountOf(plan.points, "point").c_str(),
              CountOf(plan.tiles.size(), "tile").c_str(), WithCommas(largest).c_str());
  if (plan.unusable > 0) {
    std::printf("not usable, with the status invalid_input: %s\n", CountOf(plan.unusable, "point").c_str());
  }
  if (plan.is_double) {
    std::printf("coordinates are rounded to multiples of %s\n", ExactText(plan.spacing).c_str());
  }
  std::printf("next: curv tiles run %s, with --server=HOST:PORT for a server\n", ShellWord(plan.directory).c_str());
}

// Takes out of the help what this command reads only to say why tiles cannot have it.
void HideRefusedFlags(CLI::App& command) {
  for (const char* flag : {"--auto", "--k-range", "--max-radius", "--per-cloud", "--normals", "--orient"}) {
    command.get_option(flag)->group("");
  }
  CLI::Option* estimator = command.get_option("--estimator");
  estimator->description(
      absl::StrReplaceAll(estimator->get_description(), {{", normal-regression or auto", " or normal-regression"}}));
  command.get_option("--k")->description("points in a neighborhood, itself included [50]");
  command.get_option("--jet-degree")->description("degree of jet's polynomial, 2 to 4; 4: exact positions [2]");
  command.get_option("--quantities")
      ->description(
          "what to estimate, with commas between: mean, gaussian, k1, k2, d1, d2, radius, shape_index, curvedness, or "
          "the contract's names; the result has no other columns, but k1 and k2 come together, and so do d1 and d2 "
          "[all of curvature but shape_index and curvedness]");
}

ExitCode Run(PlanFlags& flags) {
  EstimateOptions& options = flags.estimate.options;
  const absl::StatusOr<TileReach> reach = ReachOf(options);
  if (!reach.ok()) return Fail(ExitCode::kUsage, reach.status());
  PlanRequest& request = flags.request;
  request.reach = *reach;
  request.options = JsonOf(options);
  request.skip_invalid = options.skip_invalid;
  request.spacing = flags.lattice > 0.0 ? std::exp2(std::floor(std::log2(flags.lattice))) : 0.0;
  const InterruptWatch interrupt;
  const absl::StatusOr<PlanOutcome> outcome = PlanWithProgress(request, interrupt.token());
  if (!outcome.ok()) return FailTiles(outcome.status());
  for (const std::string& note : outcome->notes) PrintNote(note);
  PrintPlan(outcome->plan, flags.summary == "json");
  return ExitCode::kOk;
}

}  // namespace

void AddTilesPlan(CLI::App& tiles, Action& action) {
  auto flags = std::make_shared<PlanFlags>();
  CLI::App* command = tiles.add_subcommand("plan", "Divide clouds into tiles, in a directory");
  command->footer(kExitCodesHelp);
  command
      ->add_option("input", flags->request.inputs,
                   absl::StrCat("the clouds, which count as one: ", kReadableExtensions))
      ->required()
      ->option_text("IN...");
  command
      ->add_option("-o,--output", flags->request.directory, "the directory, which is made; there must be no plan in it")
      ->required()
      ->check(NotEmpty())
      ->option_text("DIR");
  AddInputFormat(*command, flags->request.format);
  command->add_option("--tile-points", flags->request.tile_points, "points in a tile, about [350,000]")
      ->check(Whole(100, 100'000'000))
      ->option_text("COUNT");
  command
      ->add_option("--memory", flags->request.memory_bytes,
                   "what plan and merge may take, such as 512MiB; 16MiB or more [1GiB]")
      ->transform(ByteSize(kLeastMemory))
      ->option_text("SIZE");
  command
      ->add_option("--lattice", flags->lattice,
                   "coordinates in doubles are rounded to multiples of the power of two that is this long, or shorter "
                   "[at most 2^-12 of the distance between points]")
      ->check(FinitePositive())
      ->option_text("LENGTH");
  AddEstimatorFlags(*command, flags->estimate);
  AddSourceFlags(*command, flags->estimate.normals);
  AddInvalidFlag(*command, flags->estimate);
  AddQuantitiesFlag(*command, flags->estimate.quantities);
  HideRefusedFlags(*command);
  command->add_option("--summary", flags->summary, "text [default] or json, on standard output")
      ->check(CLI::IsMember({"text", "json"}).description(""))
      ->option_text("FORMAT");
  command->callback([flags, command, &action] {
    CheckTileNormals(flags->estimate.normals);
    CheckTileQuantities(flags->estimate.quantities);
    ApplyQuantities(flags->estimate.quantities, flags->estimate.options);
    ApplyScale(flags->estimate.scale, flags->estimate.options);
    CheckEstimatorFlags(*command, flags->estimate.options);
    action = [flags] { return Run(*flags); };
  });
}

}  // namespace curv
