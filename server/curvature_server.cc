#include "server/curvature_server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <utility>

#include "absl/base/call_once.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/call_errors.h"
#include "server/curvature_service.h"
#include "server/metrics_port.h"
#include "server/service_context.h"
#include "server/ticker.h"

namespace curvd {
namespace {

constexpr auto kTick = std::chrono::milliseconds(200);
// What protobuf and a careless client may add to a chunk, so that the client gets our error and not gRPC's.
constexpr uint64_t kMessageSlackBytes = 1 << 20;
// How long calls that were ended get to deliver their status.
constexpr absl::Duration kFarewell = absl::Seconds(2);
// How long connections get to close once the last call is over. Idle clients do not notice that they should.
constexpr absl::Duration kHangUp = absl::Milliseconds(200);

void ConfigureConnections(const ServerOptions& options, grpc::ServerBuilder& builder) {
  builder.SetMaxReceiveMessageSize(static_cast<int>(options.max_chunk_bytes + kMessageSlackBytes));
  builder.SetMaxSendMessageSize(-1);
  // gRPC 1.51 limits a message before it is unpacked, so that 4 MiB could become 4 GiB; and floats hardly shrink.
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  // Two servers on one port would share its calls; the second one shall fail instead.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  // Calls that wait for memory hold 64 KiB of what their client sends. With a window that grows with the bandwidth it
  // was megabytes for each of hundreds of calls; a call that reads gets room for the message that it reads either way.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  // Notices a peer that vanished within 15 s, and lets clients do the same.
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5'000);
}

}  // namespace

class CurvatureServer::Running {
 public:
  explicit Running(const ServerOptions& options)
      : context_(options), service_(context_), ticker_(kTick, [this](Ticker::Clock::time_point now) { Tick(now); }) {}
  ~Running();

  absl::Status Start(const ServerOptions& options);
  void Drain(absl::Duration timeout);
  void Wait() { server_->Wait(); }

  int port() const { return port_; }
  int metrics_port() const { return metrics_port_ == nullptr ? 0 : metrics_port_->port(); }
  std::shared_ptr<grpc::Channel> InProcessChannel();

 private:
  void Tick(Ticker::Clock::time_point now);

  ServiceContext context_;
  CurvatureService service_;
  Ticker ticker_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<MetricsPort> metrics_port_;
  int port_ = 0;
  absl::once_flag drained_;
};

absl::Status CurvatureServer::Running::Start(const ServerOptions& options) {
  grpc::ServerBuilder builder;
  ConfigureConnections(options, builder);
  builder.RegisterService(&service_);
  int selected_port = 0;
  if (!options.listen.empty()) {
    builder.AddListeningPort(options.listen, grpc::InsecureServerCredentials(), &selected_port);
  }
  server_ = builder.BuildAndStart();
  if (server_ == nullptr || (!options.listen.empty() && selected_port == 0)) {
    return absl::UnavailableError(absl::StrCat("cannot listen on ", options.listen,
                                               " (--listen): in use, not permitted, or no address of this machine"));
  }
  port_ = absl::StartsWith(options.listen, "unix:") ? 0 : selected_port;
  server_->GetHealthCheckService()->SetServingStatus("curvature.v1.CurvatureService", true);
  if (options.metrics_listen.empty()) return absl::OkStatus();
  absl::StatusOr<std::unique_ptr<MetricsPort>> metrics = MetricsPort::Create(options.metrics_listen, context_.metrics);
  if (!metrics.ok()) return metrics.status();
  metrics_port_ = *std::move(metrics);
  return absl::OkStatus();
}

CurvatureServer::Running::~Running() {
  metrics_port_.reset();
  if (server_ == nullptr) return;
  context_.gate.StartDraining();
  for (const auto& stream : context_.gate.open_streams()) stream->Abort(DrainTimedOut(absl::ZeroDuration()));
  server_->Shutdown(std::chrono::system_clock::now());
}

void CurvatureServer::Running::Tick(Ticker::Clock::time_point now) {
  for (const auto& stream : context_.gate.open_streams()) stream->Tick(now);
}

void CurvatureServer::Running::Drain(absl::Duration timeout) {
  absl::call_once(drained_, [this, timeout] {
    server_->GetHealthCheckService()->Shutdown();
    context_.gate.StartDraining();
    if (!context_.gate.WaitUntilEmpty(timeout)) {
      for (const auto& stream : context_.gate.open_streams()) stream->Abort(DrainTimedOut(timeout));
      context_.gate.WaitUntilEmpty(kFarewell);
    }
    server_->Shutdown(absl::ToChronoTime(absl::Now() + kHangUp));
  });
}

std::shared_ptr<grpc::Channel> CurvatureServer::Running::InProcessChannel() {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetMaxSendMessageSize(-1);
  return server_->InProcessChannel(arguments);
}

absl::StatusOr<std::unique_ptr<CurvatureServer>> CurvatureServer::Create(const ServerOptions& options) {
  if (absl::Status status = options.Validate(); !status.ok()) return status;
  // Both are settings of the process, and stay as they are once they are set.
  static absl::once_flag plugins_ready;
  absl::call_once(plugins_ready, [] {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  });
  const ServerOptions resolved = options.Resolved();
  auto running = std::make_unique<Running>(resolved);
  if (absl::Status status = running->Start(resolved); !status.ok()) return status;
  return std::unique_ptr<CurvatureServer>(new CurvatureServer(std::move(running)));
}

CurvatureServer::CurvatureServer(std::unique_ptr<Running> running) : running_(std::move(running)) {}
CurvatureServer::~CurvatureServer() = default;

int CurvatureServer::port() const { return running_->port(); }
int CurvatureServer::metrics_port() const { return running_->metrics_port(); }
std::shared_ptr<grpc::Channel> CurvatureServer::InProcessChannel() { return running_->InProcessChannel(); }
void CurvatureServer::Drain(absl::Duration timeout) { running_->Drain(timeout); }
void CurvatureServer::Wait() { running_->Wait(); }

}  // namespace curvd
