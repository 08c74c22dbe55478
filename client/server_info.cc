#include "client/server_info.h"

#include <future>
#include <string>
#include <utility>

#include "absl/time/clock.h"
#include "client/rpc_error.h"
#include "curvature/v1/curvature.grpc.pb.h"
#include "google/protobuf/empty.pb.h"
#include "google/protobuf/unknown_field_set.h"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "grpcpp/generic/generic_stub.h"
#include "proto/http_date.h"

namespace curv {
namespace {

namespace v1 = curvature::v1;

// Names what this client's contract has; a newer server may know more.
std::string NameOf(int estimator) {
  const std::string_view name =
      v1::Estimator_IsValid(estimator) ? EstimatorName(static_cast<Estimator>(estimator)) : "";
  return name.empty() ? "number " + std::to_string(estimator) : std::string(name);
}

ServerInfo ToServerInfo(const v1::GetServerInfoResponse& response) {
  const v1::ServerLimits& limits = response.limits();
  ServerInfo info{.version = response.version(),
                  .cpu_kind = response.cpu_kind(),
                  .worker_threads = response.worker_threads(),
                  .estimators = {},
                  .max_points = limits.max_points(),
                  .max_chunk_bytes = limits.max_chunk_bytes(),
                  .max_neighbor_count = limits.max_neighbor_count(),
                  .memory_bytes = limits.memory_bytes(),
                  .max_streams = limits.max_streams(),
                  .health = "UNKNOWN",
                  .date = std::nullopt};
  for (const int estimator : response.estimators()) {
    info.estimators.push_back(NameOf(estimator));
  }
  return info;
}

// Asks grpc.health.v1. Its messages are so small (a string in field 1, an enum in field 1) that they are spoken as the
// unknown fields of an empty message, which spares the package a generated protocol.
absl::StatusOr<std::string> CheckHealth(const std::shared_ptr<grpc::Channel>& channel, absl::Duration timeout) {
  using google::protobuf::Empty;
  static constexpr const char* kWords[] = {"UNKNOWN", "SERVING", "NOT_SERVING", "SERVICE_UNKNOWN"};

  grpc::ClientContext context;
  context.set_deadline(absl::ToChronoTime(absl::Now() + timeout));
  Empty request, response;
  Empty::GetReflection()->MutableUnknownFields(&request)->AddLengthDelimited(1,
                                                                             v1::CurvatureService::service_full_name());
  // Shared, because the callback may still be within set_value when the waiting ends.
  const auto ended = std::make_shared<std::promise<grpc::Status>>();
  grpc::TemplatedGenericStub<Empty, Empty> stub(channel);
  stub.UnaryCall(&context, "/grpc.health.v1.Health/Check", grpc::StubOptions(), &request, &response,
                 [ended](grpc::Status status) { ended->set_value(std::move(status)); });
  const grpc::Status status = ended->get_future().get();
  uint64_t word = 0;
  const auto& fields = Empty::GetReflection()->GetUnknownFields(response);
  for (int i = 0; i < fields.field_count(); ++i) {
    if (fields.field(i).number() == 1 && fields.field(i).type() == google::protobuf::UnknownField::TYPE_VARINT) {
      word = fields.field(i).varint();
    }
  }
  if (!status.ok()) return ToAbslStatus(status);
  return std::string(word < std::size(kWords) ? kWords[word] : kWords[0]);
}

}  // namespace

absl::StatusOr<ServerInfo> AskServer(const std::shared_ptr<grpc::Channel>& channel, absl::Duration timeout) {
  grpc::ClientContext context;
  context.set_deadline(absl::ToChronoTime(absl::Now() + timeout));
  v1::GetServerInfoResponse response;
  const grpc::Status status =
      v1::CurvatureService::NewStub(channel)->GetServerInfo(&context, v1::GetServerInfoRequest(), &response);
  if (!status.ok()) return ToAbslStatus(status);
  ServerInfo info = ToServerInfo(response);
  const auto& headers = context.GetServerInitialMetadata();
  if (const auto date = headers.find(curvd::kDateHeader); date != headers.end()) {
    info.date = curvd::ParseHttpDate({date->second.data(), date->second.size()});
  }
  info.health = CheckHealth(channel, timeout).value_or("UNKNOWN");
  return info;
}

absl::StatusOr<std::string> AskHealth(const std::shared_ptr<grpc::Channel>& channel, absl::Duration timeout) {
  return CheckHealth(channel, timeout);
}

}  // namespace curv
