#include "server/net/health_port.h"

#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server_builder.h>

#include <chrono>
#include <utility>
#include <vector>

#include "absl/memory/memory.h"
#include "curvature/v1/curvature.grpc.pb.h"
#include "server/net/open_calls.h"
#include "server/net/reflection.h"

namespace curvd {
namespace {

// A probe connects, asks and leaves.
constexpr ConnectionLimits kLimits = {64, 32};
constexpr int kIdleMs = 60'000;
constexpr int kHandshakeMs = 5'000;
constexpr int kMaxMessageBytes = 4 << 10;
constexpr int kMaxStreams = 16;
// Whoever asks here is a stranger, and has little to say.
constexpr ByteAllowances kAllowances = {32 << 10, 32 << 10, kMaxMessageBytes, 8 << 10};

}  // namespace

HealthPort::HealthPort(ListeningSockets sockets, MemoryPressure& memory, ConnectionAcceptor::Events events)
    : connections_(kAllowances), acceptor_(std::move(sockets), kLimits, connections_, memory, std::move(events)) {
  grpc::ServerBuilder builder;
  builder.RegisterCallbackGenericService(&nothing_else_);
  LeaveOutReflection(builder);
  builder.SetMaxReceiveMessageSize(kMaxMessageBytes);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxStreams);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, kIdleMs);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshakeMs);
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> noters;
  noters.push_back(NoteCallsBeside("", connections_));
  builder.experimental().SetInterceptorCreators(std::move(noters));
  auto target = builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD, grpc::InsecureServerCredentials());
  server_ = builder.BuildAndStart();
  server_->GetHealthCheckService()->SetServingStatus(curvature::v1::CurvatureService::service_full_name(), true);
  acceptor_.Start(std::move(target));
}

absl::StatusOr<std::unique_ptr<HealthPort>> HealthPort::Create(const std::string& listen, MemoryPressure& memory,
                                                               ConnectionAcceptor::Events events) {
  absl::StatusOr<ListeningSockets> sockets = ListeningSockets::Bind("--health-listen", listen);
  if (!sockets.ok()) return sockets.status();
  return absl::WrapUnique(new HealthPort(*std::move(sockets), memory, std::move(events)));
}

HealthPort::~HealthPort() {
  acceptor_.Stop();
  server_->Shutdown(std::chrono::system_clock::now());
}

void HealthPort::SetNotServing() { server_->GetHealthCheckService()->Shutdown(); }

}  // namespace curvd
