#include "server/curvature_server.h"

#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <mutex>
#include <optional>
#include <utility>

#include "absl/base/call_once.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/access/credential_files.h"
#include "server/call/curvature_service.h"
#include "server/host/descriptor_limit.h"
#include "server/host/memory_pressure.h"
#include "server/host/memory_reuse.h"
#include "server/host/ticker.h"
#include "server/net/connection_acceptor.h"
#include "server/net/health_port.h"
#include "server/net/keepalive.h"
#include "server/net/metrics_port.h"
#include "server/net/open_calls.h"
#include "server/net/reflection.h"
#include "server/net/strangers.h"
#include "server/rpc/ending_errors.h"
#include "server/service_context.h"

namespace curvd {
namespace {

constexpr auto kTick = std::chrono::milliseconds(200);
// What a call holds that waits for memory: the 64 KiB that its peer may send, and its own objects.
constexpr uint64_t kWaitingCallBytes = 80 << 10;
// How long calls that were ended get to deliver their status.
constexpr absl::Duration kFarewell = absl::Seconds(2);
// How long connections get to close once the last call is over. Idle clients do not notice that they should.
constexpr absl::Duration kHangUp = absl::Milliseconds(200);

// After this gRPC asks a client to connect again, once its calls are over: so it comes to new replicas, and shows a
// certificate that is still good.
constexpr absl::Duration kConnectionAge = absl::Hours(1);
// Streams of a connection above max_streams_per_peer: health, and calls that shall hear of the limit from us.
constexpr int kStreamSlack = 100;
// How soon a certificate, a token or a name that has changed is noticed.
constexpr auto kReloadInterval = std::chrono::seconds(1);

int Milliseconds(absl::Duration duration) {
  return static_cast<int>(std::min<int64_t>(absl::ToInt64Milliseconds(duration), INT_MAX));
}

// gRPC counts each ping of a client without calls against it, as the server sends none itself then. So many a client
// may send that asks every kClientsPingIntervalMs for as long as it may be idle.
int MaxPingStrikes(absl::Duration idle_timeout) {
  constexpr int kMost = 10'000;
  return 2 + std::min(kMost, Milliseconds(idle_timeout) / kClientsPingIntervalMs);
}

void ConfigureConnections(const ServerOptions& options, grpc::ServerBuilder& builder) {
  builder.SetMaxReceiveMessageSize(static_cast<int>(options.max_message_bytes()));
  builder.SetMaxSendMessageSize(-1);
  // gRPC 1.51 limits a message before it is unpacked, so that 4 MiB could become 4 GiB; and floats hardly shrink.
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  // Calls that wait for memory hold 64 KiB of what their client sends. With a window that grows with the bandwidth it
  // was megabytes for each of hundreds of calls; a call that reads gets room for the message that it reads either way.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  // Notices within 15 s that the peer of an open call vanished, and lets clients do the same.
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, Milliseconds(options.keepalive_time));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, Milliseconds(options.keepalive_timeout));
  // A process with many idle connections on gRPC's C++ core (C++, Python) reads from one of them every 5 s: it could
  // not answer in time. Whether the machine behind an idle connection is there, the system asks (ConnectionAcceptor).
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 0);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, kClientsPingIntervalMs);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MAX_PING_STRIKES, MaxPingStrikes(options.idle_timeout));
  // What a stranger may hold.
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, Milliseconds(options.handshake_timeout));
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, Milliseconds(options.idle_timeout));
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_MS, Milliseconds(kConnectionAge));
  builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, static_cast<int>(options.max_header_bytes));
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS,
                             static_cast<int>(options.max_streams_per_peer) + kStreamSlack);
}

std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> AddAcceptor(TlsCredentials* tls,
                                                                            grpc::ServerBuilder& builder) {
  return builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
      tls == nullptr ? grpc::InsecureServerCredentials() : tls->ForServer());
}

}  // namespace

class CurvatureServer::Running {
 public:
  explicit Running(const ServerOptions& options)
      : context_(options),
        memory_(options.owns_process ? options.memory_limit_bytes : MemoryPressure::kAnyLimit),
        files_(options, context_.access, context_.security_metrics, context_.log),
        service_(context_),
        ticker_(kTick, [this](Ticker::Clock::time_point now) { Tick(now); }) {}
  ~Running();

  absl::Status Start(const ServerOptions& options);
  void Drain(absl::Duration timeout);
  void Wait() { server_->Wait(); }

  int port() const { return acceptor_ == nullptr ? 0 : acceptor_->port(); }
  int health_port() const { return health_port_ == nullptr ? 0 : health_port_->port(); }
  int metrics_port() const { return metrics_port_ == nullptr ? 0 : metrics_port_->port(); }
  std::shared_ptr<grpc::Channel> InProcessChannel();

 private:
  absl::Status Listen(const ServerOptions& options);
  ConnectionAcceptor::Events WatchConnections(const ServerOptions& options);
  ConnectionAcceptor::Events WatchProbes();
  absl::Status ListenBeside(const ServerOptions& options);
  void Tick(Ticker::Clock::time_point now);
  void RefreshFiles();

  ServiceContext context_;
  MemoryPressure memory_;
  CredentialFiles files_;
  CurvatureService service_;
  Ticker ticker_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<ConnectionAcceptor> acceptor_;
  std::unique_ptr<HealthPort> health_port_;
  std::unique_ptr<MetricsPort> metrics_port_;
  std::optional<Ticker> refresh_files_;
  absl::once_flag drained_;
};

absl::Status CurvatureServer::Running::Start(const ServerOptions& options) {
  if (absl::Status status = files_.LoadAll(); !status.ok()) return status;
  if (absl::Status status = Listen(options); !status.ok()) return status;
  if (absl::Status status = ListenBeside(options); !status.ok()) return status;
  refresh_files_.emplace(kReloadInterval, [this](Ticker::Clock::time_point) { RefreshFiles(); });
  return absl::OkStatus();
}

absl::Status CurvatureServer::Running::Listen(const ServerOptions& options) {
  std::optional<ListeningSockets> sockets;
  if (!options.listen.empty()) {
    absl::StatusOr<ListeningSockets> bound = ListeningSockets::Bind("--listen", options.listen);
    if (!bound.ok()) return bound.status();
    sockets.emplace(*std::move(bound));
  }
  grpc::ServerBuilder builder;
  ConfigureConnections(options, builder);
  builder.RegisterService(&service_);
  // It could not ask for a token.
  if (!options.token_file.empty()) LeaveOutReflection(builder);
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> target;
  if (sockets.has_value()) {
    target = AddAcceptor(files_.tls(), builder);
    std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> noters;
    noters.push_back(NoteCallsBeside(curvature::v1::CurvatureService::service_full_name(), context_.connections));
    builder.experimental().SetInterceptorCreators(std::move(noters));
  }
  server_ = builder.BuildAndStart();
  if (server_ == nullptr) return absl::InternalError("gRPC could not start the server");
  server_->GetHealthCheckService()->SetServingStatus(curvature::v1::CurvatureService::service_full_name(), true);
  if (!sockets.has_value()) return absl::OkStatus();
  acceptor_ = std::make_unique<ConnectionAcceptor>(
      *std::move(sockets),
      ConnectionLimits{ConnectionsWithin(options.max_connections), options.max_connections_per_peer},
      context_.connections, memory_, WatchConnections(options));
  context_.security_metrics.ReadConnectionsFrom([this] { return context_.connections.size(); });
  acceptor_->Start(std::move(target));
  return absl::OkStatus();
}

ConnectionAcceptor::Events CurvatureServer::Running::WatchConnections(const ServerOptions& options) {
  const auto handshake_timeout = absl::ToChronoNanoseconds(options.handshake_timeout);
  ConnectionAcceptor::Events events;
  events.refused = [this](StrangerReason reason, const std::string& peer) {
    context_.strangers.Note({reason, peer, {}, {}});
  };
  events.ended = [this, handshake_timeout](const ConnectionRecord& connection, Ticker::Clock::duration age) {
    const std::optional<StrangerReason> reason = WhyStranger(connection, age, handshake_timeout);
    if (!reason.has_value()) return;
    context_.strangers.Note(
        {*reason, connection.peer, std::chrono::duration<double>(age).count(), connection.received_bytes});
  };
  return events;
}

// Whoever connects to the health port may: only those are told of that were turned away.
ConnectionAcceptor::Events CurvatureServer::Running::WatchProbes() {
  ConnectionAcceptor::Events events;
  events.refused = [this](StrangerReason reason, const std::string& peer) {
    context_.strangers.Note({reason, peer, {}, {}});
  };
  events.ended = [this](const ConnectionRecord& connection, Ticker::Clock::duration age) {
    if (!connection.closed_for.has_value()) return;
    context_.strangers.Note({*connection.closed_for, connection.peer, std::chrono::duration<double>(age).count(),
                             connection.received_bytes});
  };
  return events;
}

absl::Status CurvatureServer::Running::ListenBeside(const ServerOptions& options) {
  if (!options.health_listen.empty()) {
    absl::StatusOr<std::unique_ptr<HealthPort>> health =
        HealthPort::Create(options.health_listen, memory_, WatchProbes());
    if (!health.ok()) return health.status();
    health_port_ = *std::move(health);
  }
  if (options.metrics_listen.empty()) return absl::OkStatus();
  std::vector<std::shared_ptr<prometheus::Collectable>> collectables = context_.metrics.collectables();
  for (const auto& collectable : context_.security_metrics.collectables()) collectables.push_back(collectable);
  absl::StatusOr<std::unique_ptr<MetricsPort>> metrics =
      MetricsPort::Create(options.metrics_listen, std::move(collectables));
  if (!metrics.ok()) return metrics.status();
  metrics_port_ = *std::move(metrics);
  return absl::OkStatus();
}

void CurvatureServer::Running::RefreshFiles() {
  if (!files_.Refresh()) return;
  // A call that was let in by what was taken away does not go on.
  context_.gate.EndWhere([this](const Caller& caller) { return context_.access.Recheck(caller); });
}

CurvatureServer::Running::~Running() {
  refresh_files_.reset();
  health_port_.reset();
  metrics_port_.reset();
  if (acceptor_ != nullptr) acceptor_->Stop();
  if (server_ == nullptr) return;
  context_.gate.StartDraining();
  for (const auto& stream : context_.gate.open_streams()) stream->Abort(DrainTimedOut(absl::ZeroDuration()));
  server_->Shutdown(std::chrono::system_clock::now());
}

void CurvatureServer::Running::Tick(Ticker::Clock::time_point now) {
  context_.admission.Tick();
  for (const auto& stream : context_.gate.open_streams()) stream->Tick(now);
  ReturnUnusedPages();
  memory_.Expect(context_.admission.waiting() * kWaitingCallBytes);
  memory_.Tick(now);
}

void CurvatureServer::Running::Drain(absl::Duration timeout) {
  absl::call_once(drained_, [this, timeout] {
    server_->GetHealthCheckService()->Shutdown();
    if (health_port_ != nullptr) health_port_->SetNotServing();
    context_.gate.StartDraining();
    if (!context_.gate.WaitUntilEmpty(timeout)) {
      for (const auto& stream : context_.gate.open_streams()) stream->Abort(DrainTimedOut(timeout));
      context_.gate.WaitUntilEmpty(kFarewell);
    }
    if (acceptor_ != nullptr) acceptor_->Stop();
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
  // A setting of the process, which stays as it is once it is set.
  static absl::once_flag health_ready;
  absl::call_once(health_ready, [] { grpc::EnableDefaultHealthCheckService(true); });
  const ServerOptions resolved = options.Resolved();
  auto running = std::make_unique<Running>(resolved);
  if (absl::Status status = running->Start(resolved); !status.ok()) return status;
  return std::unique_ptr<CurvatureServer>(new CurvatureServer(std::move(running)));
}

CurvatureServer::CurvatureServer(std::unique_ptr<Running> running) : running_(std::move(running)) {}
CurvatureServer::~CurvatureServer() = default;

int CurvatureServer::port() const { return running_->port(); }
int CurvatureServer::health_port() const { return running_->health_port(); }
int CurvatureServer::metrics_port() const { return running_->metrics_port(); }
std::shared_ptr<grpc::Channel> CurvatureServer::InProcessChannel() { return running_->InProcessChannel(); }
void CurvatureServer::Drain(absl::Duration timeout) { running_->Drain(timeout); }
void CurvatureServer::Wait() { running_->Wait(); }

}  // namespace curvd
