#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/cli/json.h"
#include "client/cli/numbers.h"
#include "client/cli/tiles/tile_commands.h"
#include "client/tiles/tile_status.h"

namespace curv {
namespace {

struct VerifyFlags {
  std::string directory;
  bool json = false;
};

ExitCode Run(const VerifyFlags& flags) {
  const absl::StatusOr<TilePlan> plan = LoadPlan(flags.directory);
  if (!plan.ok()) return FailTiles(plan.status());
  nlohmann::ordered_json damaged = nlohmann::ordered_json::array();
  uint64_t missing = 0;
  for (const TileFault& fault : VerifyTiles(*plan)) {
    if (absl::IsNotFound(fault.status)) {
      ++missing;
      continue;
    }
    damaged.push_back({{"tile", fault.tile}, {"message", std::string(fault.status.message())}});
    if (!flags.json) Fail(ExitCode::kInput, fault.status);
  }
  const uint64_t good = plan->tiles.size() - missing - damaged.size();
  if (flags.json) {
    std::fputs(
        ToJsonLine({{"tiles", plan->tiles.size()}, {"good", good}, {"missing", missing}, {"damaged", damaged}}).c_str(),
        stdout);
  } else {
    std::printf("%s: %s good, %s not done, %s damaged\n", CountOf(plan->tiles.size(), "tile").c_str(),
                WithCommas(good).c_str(), WithCommas(missing).c_str(), WithCommas(damaged.size()).c_str());
  }
  return missing == 0 && damaged.empty() ? ExitCode::kOk : ExitCode::kInput;
}

}  // namespace

void AddTilesVerify(CLI::App& tiles, Action& action) {
  auto flags = std::make_shared<VerifyFlags>();
  CLI::App* command = tiles.add_subcommand("verify", "Compare the results of tiles with their checksums");
  command->footer(absl::StrCat("The exit code is 3 unless all tiles are done and good.\n", kExitCodesHelp));
  AddPlanDirectory(*command, flags->directory);
  command->add_flag("--json", flags->json, "one line of JSON");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
