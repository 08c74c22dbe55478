#include <algorithm>
#include <csignal>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/cli/command.h"
#include "client/cli/connection_flags.h"
#include "client/cli/doctor/examine.h"
#include "client/cli/flags.h"
#include "client/cli/json.h"
#include "client/server_target.h"

namespace curv {
namespace {

constexpr char kHelp[] =
    "Looks at a server step by step: its name, its addresses, what is spoken there, its certificate, version, health,\n"
    "limits and clock, and whether it lets you in. Every line says what was found; below a fault stands what to do.\n"
    "Exit codes: 0 nothing is wrong; 1 the server does not let you in; 2 wrong flags; 5 it cannot be reached, or "
    "serves\n"
    "no clouds now. Warnings do not count.";

struct DoctorFlags {
  ConnectionFlags connection;
  double timeout = 5.0;
  bool json = false;
};

struct Examined {
  std::string server;
  Findings findings;
};

// Faults of the caller alone leave the server able to serve others.
ExitCode CodeFor(const std::vector<Examined>& all) {
  ExitCode code = ExitCode::kOk;
  for (const Examined& each : all) {
    for (const Finding& finding : each.findings.all()) {
      if (finding.verdict != Verdict::kFault) continue;
      if (finding.check != "caller") return ExitCode::kUnavailable;
      code = ExitCode::kFailed;
    }
  }
  return code;
}

size_t CountOf(const std::vector<Examined>& all, Verdict verdict) {
  size_t count = 0;
  for (const Examined& each : all) count += each.findings.Count(verdict);
  return count;
}

std::string Text(const std::vector<Examined>& all) {
  std::string text;
  for (const Examined& each : all) absl::StrAppend(&text, each.server, "\n", each.findings.Text());
  const size_t faults = CountOf(all, Verdict::kFault), warnings = CountOf(all, Verdict::kWarning);
  absl::StrAppend(&text, faults == 0 ? "Nothing is wrong" : absl::StrCat("Faults: ", faults),
                  warnings == 0 ? "" : absl::StrCat("; warnings: ", warnings), ".\n");
  return text;
}

std::string Json(const std::vector<Examined>& all) {
  nlohmann::ordered_json servers = nlohmann::ordered_json::array();
  for (const Examined& each : all) servers.push_back({{"server", each.server}, {"findings", each.findings.Json()}});
  return ToJsonLine({{"servers", std::move(servers)},
                     {"faults", CountOf(all, Verdict::kFault)},
                     {"warnings", CountOf(all, Verdict::kWarning)}});
}

ExitCode Run(const DoctorFlags& flags) {
  absl::StatusOr<ConnectOptions> connect = ReadConnectOptions(flags.connection);
  if (!connect.ok()) return Fail(ExitCode::kUsage, connect.status());
  if (const absl::Status status = CheckConnectOptions(*connect); !status.ok()) return Fail(ExitCode::kUsage, status);
  // A server that hangs up while OpenSSL writes is a finding.
  std::signal(SIGPIPE, SIG_IGN);
  const ExamineOptions options{*std::move(connect), absl::Seconds(flags.timeout), CURVD_VERSION};
  std::vector<Examined> all;
  const std::string servers = flags.connection.server.empty() ? "localhost" : flags.connection.server;
  const absl::StatusOr<std::vector<std::string>> targets = ReadServerTargets(servers);
  if (!targets.ok()) return Fail(ExitCode::kUsage, targets.status());
  for (const std::string& server : *targets) all.push_back({server, Examine(server, options)});
  std::fputs((flags.json ? Json(all) : Text(all)).c_str(), stdout);
  return CodeFor(all);
}

}  // namespace

void AddDoctor(CLI::App& app, Action& action) {
  auto flags = std::make_shared<DoctorFlags>();
  CLI::App* command = app.add_subcommand("doctor", "Find out what is wrong between here and a server, and what to do");
  command->footer(kHelp);
  AddConnectionFlags(*command, flags->connection);
  command->get_option("--server")->description("HOST:PORT of curvd, or several with commas between [localhost:50061]");
  command->add_option("--timeout", flags->timeout, "seconds to wait in each step [5]")
      ->check(FinitePositive())
      ->option_text("SECONDS");
  command->add_flag("--json", flags->json, "one line of JSON instead of a table");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace curv
