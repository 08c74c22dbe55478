#include "server/net/health_port.h"

#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server_builder.h>

#include <chrono>
#include <utility>

#include "absl/memory/memory.h"
#include "curvature/v1/curvature.grpc.pb.h"
#include "server/net/reflection.h"

namespace curvd {
namespace {

// A probe connects, asks and leaves.
constexpr ConnectionLimits kLimits = {64, 32};
constexpr int kIdleMs = 60'000;
constexpr int kHandshakeMs = 5'000;
constexpr int kMaxMessageBytes = 4 << 10;
constexpr int kMaxStreams = 16;

}  // namespace

HealthPort::HealthPort(ListeningSockets sockets, OnRefused on_refused)
    // Whoever connects here may, so that no end of a connection is a stranger's.
    : acceptor_(std::move(sockets), kLimits, connections_, {std::move(on_refused), nullptr}) {
  grpc::ServerBuilder builder;
  builder.RegisterCallbackGenericService(&nothing_else_);
  LeaveOutReflection(builder);
  builder.SetMaxReceiveMessageSize(kMaxMessageBytes);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxStreams);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, kIdleMs);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshakeMs);
  auto target = builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD, grpc::InsecureServerCredentials());
  server_ = builder.BuildAndStart();
  server_->GetHealthCheckService()->SetServingStatus(curvature::v1::CurvatureService::service_full_name(), true);
  acceptor_.Start(std::move(target));
}

absl::StatusOr<std::unique_ptr<HealthPort>> HealthPort::Create(const std::string& listen, OnRefused on_refused) {
  absl::StatusOr<ListeningSockets> sockets = ListeningSockets::Bind("--health-listen", listen);
  if (!sockets.ok()) return sockets.status();
  return absl::WrapUnique(new HealthPort(*std::move(sockets), std::move(on_refused)));
}

HealthPort::~HealthPort() {
  acceptor_.Stop();
  server_->Shutdown(std::chrono::system_clock::now());
}

void HealthPort::SetNotServing() { server_->GetHealthCheckService()->Shutdown(); }

}  // namespace curvd
