// curvd: serves until a signal says stop.
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <future>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "about/version_line.h"
#include "absl/strings/str_cat.h"
#include "google/protobuf/stubs/logging.h"
#include "server/access/watched_file.h"
#include "server/curvature_server.h"
#include "server/flags.h"
#include "server/host/descriptor_limit.h"
#include "server/host/memory_reuse.h"
#include "server/host/thread_stacks.h"
#include "server/host/version.h"
#include "server/net/listen_address.h"
#include "server/observe/grpc_log.h"
#include "server/observe/json_line.h"
#include "server/observe/server_log.h"

namespace curvd {
namespace {

// Exit statuses.
constexpr int kOk = 0;
constexpr int kCannotServe = 1;
constexpr int kBadFlags = 2;
constexpr int kKilledWhileDraining = 3;

sigset_t StopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  return signals;
}

// Waits for a stop signal on a thread of its own, since a second one must end the process whatever the drain does.
std::future<int> WatchSignals() {
  std::promise<int> first;
  std::future<int> stopped = first.get_future();
  std::thread([first = std::move(first)]() mutable {
    const sigset_t signals = StopSignals();
    int signal = 0;
    sigwait(&signals, &signal);
    first.set_value(signal);
    sigwait(&signals, &signal);
    _exit(kKilledWhileDraining);
  }).detach();
  return stopped;
}

std::string WithPort(const std::string& listen, int port) {
  return port == 0 ? listen : absl::StrCat(listen.substr(0, listen.rfind(':')), ":", port);
}

// Whether the files that flags name can be read. What they hold is looked at later.
absl::Status CheckFiles(const ServerOptions& options) {
  for (const auto& [flag, path] : {std::pair("--tls-cert", &options.tls_cert),
                                   {"--tls-key", &options.tls_key},
                                   {"--tls-client-ca", &options.tls_client_ca},
                                   {"--tls-client-names", &options.tls_client_names},
                                   {"--token-file", &options.token_file}}) {
    if (path->empty()) continue;
    const absl::Status status = WatchedFile(*path).Read().status();
    if (!status.ok()) return absl::Status(status.code(), absl::StrCat(flag, ": ", status.message()));
  }
  return absl::OkStatus();
}

int Serve(const ServerOptions& options, const std::vector<std::string>& warnings) {
  ServerLog log(options.log);
  const GrpcLogRoute grpc_log(log);
  absl::StatusOr<std::unique_ptr<CurvatureServer>> server = CurvatureServer::Create(options);
  if (!server.ok()) {
    std::fprintf(stderr, "curvd: %s\n", std::string(server.status().message()).c_str());
    return kCannotServe;
  }
  if (!IsLocalAddress(options.listen) && options.tls_cert.empty()) {
    log.Log(ServerLog::Level::kWarning, "unencrypted",
            JsonLine()
                .Add("listen", options.listen)
                .Add("message", "--insecure: what other machines send, tokens included, is not encrypted"));
  }
  for (const std::string& warning : warnings) {
    log.Log(ServerLog::Level::kWarning, "unknown_variable", JsonLine().Add("message", warning));
  }
  std::future<int> stopped = WatchSignals();
  log.Log(ServerLog::Level::kInfo, "serving",
          JsonLine()
              .Add("version", Version())
              .Add("listen", WithPort(options.listen, (*server)->port()))
              .Add("tls", options.tls_cert.empty()        ? "none"
                          : options.tls_client_ca.empty() ? "server"
                                                          : "mutual")
              .Add("tokens", !options.token_file.empty())
              .Add("health_listen", WithPort(options.health_listen, (*server)->health_port()))
              .Add("metrics_listen", WithPort(options.metrics_listen, (*server)->metrics_port())));
  const int signal = stopped.get();
  log.Log(ServerLog::Level::kInfo, "draining",
          JsonLine().Add("signal", signal).Add("timeout_seconds", absl::ToDoubleSeconds(options.drain_timeout)));
  (*server)->Drain(options.drain_timeout);
  server->reset();
  log.Log(ServerLog::Level::kInfo, "stopped", JsonLine());
  return kOk;
}

int Main(int argc, char** argv) {
  // Before any thread exists, so that all inherit it: only the watcher gets the signals.
  const sigset_t signals = StopSignals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  // A log reader that goes away must not end the server.
  signal(SIGPIPE, SIG_IGN);
  // Whoever sends it wants files to be read again, which happens by itself.
  signal(SIGHUP, SIG_IGN);
  // What it would write, that a message cannot be parsed, no caller shall put between the log's lines.
  google::protobuf::SetLogHandler(nullptr);
  RaiseDescriptorLimit();
  LimitThreadStacks();
  const absl::StatusOr<CommandLine> line = ParseCommandLine(argc, argv, VersionLine("curvd"));
  if (!line.ok()) {
    std::fprintf(stderr, "curvd: %s\n", std::string(line.status().message()).c_str());
    return kBadFlags;
  }
  if (!line->answer.empty()) {
    std::fputs(line->answer.c_str(), stdout);
    return kOk;
  }
  if (const absl::Status status = CheckFiles(line->options); !status.ok()) {
    std::fprintf(stderr, "curvd: %s\n", std::string(status.message()).c_str());
    return kBadFlags;
  }
  ReuseFreedMemory(line->options.Resolved().memory_limit_bytes);
  ServerOptions options = line->options;
  options.owns_process = true;
  return Serve(options, line->warnings);
}

}  // namespace
}  // namespace curvd

int main(int argc, char** argv) { return curvd::Main(argc, argv); }
