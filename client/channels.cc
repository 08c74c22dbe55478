#include "client/channels.h"

#include <random>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/support/channel_arguments.h"

namespace curv {
namespace {

bool LooksLikeTarget(const std::string& server) {
  const size_t colon = server.rfind(':');
  return colon != std::string::npos && colon > 0 && colon + 1 < server.size();
}

std::shared_ptr<grpc::Channel> MakeChannel(const std::string& server) {
  grpc::ChannelArguments arguments;
  // Result chunks are far smaller; a server that sends more is not curvd.
  arguments.SetMaxReceiveMessageSize(64 << 20);
  // A name with several addresses is a set of replicas.
  arguments.SetLoadBalancingPolicyName("round_robin");
  // Notices within 15 s that a server vanished, also while it computes and says nothing.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 10'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5'000);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  // A server that came back is found by the next attempt, one that drops packets is given up.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 250);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2'000);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 5'000);
  // Between two clients of one process no connection is shared, so that each goes to a server of its own.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(server, grpc::InsecureChannelCredentials(), arguments);
}

}  // namespace

absl::StatusOr<std::unique_ptr<CurvatureClient::Channels>> CurvatureClient::Channels::Create(std::string_view servers) {
  std::vector<std::shared_ptr<grpc::Channel>> channels;
  const std::string list(servers);
  for (const absl::string_view part : absl::StrSplit(list, ',')) {
    const std::string server(absl::StripAsciiWhitespace(part));
    if (!LooksLikeTarget(server)) {
      return absl::InvalidArgumentError(
          absl::StrCat("server \"", server, "\" is not HOST:PORT, as in 127.0.0.1:50061"));
    }
    channels.push_back(MakeChannel(server));
  }
  // Many short processes together spread over the replicas as well.
  const size_t start = channels.size() == 1 ? 0 : std::random_device()();
  return std::make_unique<Channels>(std::move(channels), start);
}

}  // namespace curv
