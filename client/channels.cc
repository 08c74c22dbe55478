#include "client/channels.h"

#include "absl/random/random.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/name_lookup.h"
#include "client/server_target.h"
#include "client/token_interceptor.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/support/channel_arguments.h"
#include "proto/open_ssl.h"

namespace curv {
namespace {

std::shared_ptr<grpc::ChannelCredentials> MakeCredentials(const ConnectOptions& options) {
  if (!options.tls) return grpc::InsecureChannelCredentials();
  curvd::KeepOpenSslAtExit();
  return grpc::SslCredentials({options.authorities, options.private_key, options.certificate});
}

// Where a channel connects to, and the name under which that was asked for, which proxies and certificates go by.
struct Place {
  std::string target;
  std::string authority;  // empty: that of the target
};

// A place for each address of `server`; a single one, which gRPC looks up, where there is one address, or none.
// Addresses of the family that the system prefers: a server may listen on that alone.
std::vector<Place> PlacesOf(const std::string& server) {
  const size_t colon = server.rfind(':');
  const std::string host = server.substr(0, colon);
  std::vector<Place> places;
  if (host != "localhost" && !absl::StrContains(host, ':')) {
    const auto addresses = LookUp(host, server.substr(colon + 1));
    for (size_t i = 0; addresses.ok() && i < addresses->size(); ++i) {
      const Address& address = (*addresses)[i];
      if (address.bytes.ss_family == addresses->front().bytes.ss_family) places.push_back({address.text, server});
    }
  }
  return places.size() > 1 ? places : std::vector<Place>{{server, ""}};
}

std::shared_ptr<grpc::Channel> MakeChannel(const Place& place, const ConnectOptions& options) {
  grpc::ChannelArguments arguments;
  // Result chunks are far smaller; a server that sends more is not curvd.
  arguments.SetMaxReceiveMessageSize(64 << 20);
  // What fails is tried again here, by what the server says. gRPC 1.51 may leave a call open for good, whatever its
  // deadline, that it tried again by itself after the server was drained.
  arguments.SetInt(GRPC_ARG_ENABLE_RETRIES, 0);
  // A name with several addresses is a set of replicas.
  arguments.SetLoadBalancingPolicyName("round_robin");
  // Notices within 30 s that a server vanished, also while it computes and says nothing. On a slow line the question
  // waits behind points that are on their way, for some seconds.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 10'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 20'000);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  // A server that came back is found by the next attempt, one that drops packets is given up.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 250);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2'000);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 5'000);
  // Between two clients of one process no connection is shared, so that each goes to a server of its own.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  if (!place.authority.empty()) arguments.SetString(GRPC_ARG_DEFAULT_AUTHORITY, place.authority);
  if (!options.server_name.empty()) {
    arguments.SetSslTargetNameOverride(options.server_name);
  } else if (options.tls && !place.authority.empty()) {
    arguments.SetSslTargetNameOverride(place.authority.substr(0, place.authority.rfind(':')));
  }
  std::vector<std::unique_ptr<grpc::experimental::ClientInterceptorFactoryInterface>> interceptors;
  if (!options.token.empty()) interceptors.push_back(std::make_unique<TokenInterceptorFactory>(options.token));
  return grpc::experimental::CreateCustomChannelWithInterceptors(place.target, MakeCredentials(options), arguments,
                                                                 std::move(interceptors));
}

}  // namespace

absl::StatusOr<std::unique_ptr<CurvatureClient::Channels>> CurvatureClient::Channels::Create(
    std::string_view servers, const ConnectOptions& options) {
  if (absl::Status status = CheckConnectOptions(options); !status.ok()) return status;
  const absl::StatusOr<std::vector<std::string>> targets = ReadServerTargets({servers.data(), servers.size()});
  if (!targets.ok()) return targets.status();
  std::vector<std::shared_ptr<grpc::Channel>> channels;
  for (const std::string& server : *targets) {
    if (!options.token.empty() && !options.tls && !options.send_token_in_plain_text && !IsLocalTarget(server)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "the token would go to ", server,
          " in plain text, where others can read it: use TLS (--tls), or insist (--send-token-in-plain-text)"));
    }
    for (const Place& place : options.resolve_once ? PlacesOf(server) : std::vector<Place>{{server, ""}}) {
      channels.push_back(MakeChannel(place, options));
    }
  }
  // Many short processes together spread over the replicas as well.
  absl::BitGen bits;
  const size_t start = absl::Uniform<size_t>(bits, 0, channels.size());
  auto created = std::make_unique<Channels>(std::move(channels), start);
  created->connect_ = true;
  created->tls_ = options.tls;
  created->has_certificate_ = !options.certificate.empty();
  return created;
}

}  // namespace curv
