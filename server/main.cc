// curvd: serves until a signal says stop.
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <future>
#include <thread>
#include <utility>

#include "about/version_line.h"
#include "absl/strings/str_cat.h"
#include "google/protobuf/stubs/logging.h"
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

int Serve(const ServerOptions& options) {
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
  ReuseFreedMemory(line->options.Resolved().memory_limit_bytes);
  ServerOptions options = line->options;
  options.owns_process = true;
  return Serve(options);
}

}  // namespace
}  // namespace curvd

int main(int argc, char** argv) { return curvd::Main(argc, argv); }
