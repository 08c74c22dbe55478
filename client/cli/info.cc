#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "client/cli/command.h"
#include "client/cli/connection.h"
#include "client/cli/flags.h"
#include "client/cli/json.h"
#include "client/cli/numbers.h"

namespace curv {
namespace {

struct InfoFlags {
  ConnectionFlags connection;
  double timeout = 10.0;
  bool json = false;
  bool health = false;
};

// What Highway calls AVX3 is AVX-512; AVX3_DL, AVX3_ZEN4 and AVX3_SPR have more of it.
std::string InstructionSet(const std::string& cpu_kind) {
  return absl::StrReplaceAll(cpu_kind, {{"AVX3", "AVX-512"}, {"_", " "}});
}

std::string Text(const ServerInfo& info) {
  std::string text;
  const auto line = [&text](const char* name, const std::string& value) {
    absl::StrAppendFormat(&text, "%-24s %s\n", name, value);
  };
  line("version", info.version);
  line("health", info.health);
  line("estimators", absl::StrJoin(info.estimators, ", "));
  line("worker threads", absl::StrCat(info.worker_threads));
  line("instruction set", InstructionSet(info.cpu_kind));
  line("points in a cloud", absl::StrCat("at most ", WithCommas(info.max_points)));
  line("points in a neighborhood", absl::StrCat("at most ", WithCommas(info.max_neighbor_count)));
  line("bytes of a chunk", absl::StrCat("at most ", WithCommas(info.max_chunk_bytes)));
  line("bytes of all calls", info.memory_bytes == 0 ? "not limited" : "at most " + WithCommas(info.memory_bytes));
  line("open calls", absl::StrCat("at most ", WithCommas(info.max_streams)));
  return text;
}

std::string Json(const ServerInfo& info) {
  return ToJsonLine({{"version", info.version},
                     {"health", info.health},
                     {"estimators", absl::StrJoin(info.estimators, " ")},
                     {"worker_threads", info.worker_threads},
                     {"cpu_kind", info.cpu_kind},
                     {"limits",
                      {{"max_points", info.max_points},
                       {"max_neighbor_count", info.max_neighbor_count},
                       {"max_chunk_bytes", info.max_chunk_bytes},
                       {"memory_bytes", info.memory_bytes},
                       {"max_streams", info.max_streams}}}});
}

ExitCode RunHealth(const CurvatureClient& client, absl::Duration timeout) {
  const absl::StatusOr<std::string> health = client.GetHealth(timeout);
  if (!health.ok()) return FailCall(health.status());
  std::printf("%s\n", health->c_str());
  return *health == "SERVING" ? ExitCode::kOk : ExitCode::kUnavailable;
}

ExitCode Run(const InfoFlags& flags) {
  absl::StatusOr<std::unique_ptr<Connection>> connection = Connection::Create(flags.connection, /*threads=*/0);
  if (!connection.ok()) return Fail(ExitCode::kUsage, connection.status());
  if (flags.health) return RunHealth((*connection)->client(), absl::Seconds(flags.timeout));
  absl::StatusOr<ServerInfo> info = (*connection)->client().GetServerInfo(absl::Seconds(flags.timeout));
  if (!info.ok()) return FailCall(info.status());
  std::fputs((flags.json ? Json(*info) : Text(*info)).c_str(), stdout);
  return ExitCode::kOk;
}

}  // namespace

void AddInfo(CLI::App& app, Action& action) {
  auto flags = std::make_shared<InfoFlags>();
  CLI::App* command = app.add_subcommand("info", "Tell version, limits, estimators and health of a server");
  command->footer(kExitCodesHelp);
  AddConnectionFlags(*command, flags->connection);
  command->add_option("--timeout", flags->timeout, "seconds to wait for a server [10]")
      ->check(FinitePositive())
      ->option_text("SECONDS");
  command->add_flag("--json", flags->json, "one line of JSON instead of a table");
  command->add_flag("--health", flags->health,
                    "ask for health alone, which needs no token; exit 0 if it is SERVING, else 5");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
