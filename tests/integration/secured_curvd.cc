#include "tests/integration/secured_curvd.h"

#include "absl/strings/str_cat.h"
#include "proto/access_list.h"
#include "tests/integration/test_server.h"

namespace curvd {

SecuredCurvd::SecuredCurvd(const std::vector<std::string>& more_flags) {
  const PemPair server = certificates_.Issue("localhost");
  std::vector<std::string> flags = {
      "--listen=127.0.0.1:0",
      "--metrics-listen=127.0.0.1:0",
      "--health-listen=127.0.0.1:0",
      "--threads=2",
      absl::StrCat("--tls-cert=", dir_.Write("server.crt", server.certificate)),
      absl::StrCat("--tls-key=", dir_.Write("server.key", server.key)),
      absl::StrCat("--tls-client-ca=", dir_.Write("ca.crt", certificates_.authority())),
      absl::StrCat("--tls-client-names=", dir_.Write("names", "friend\n")),
      absl::StrCat("--token-file=", dir_.File("tokens")),
  };
  WriteTokens();
  flags.insert(flags.end(), more_flags.begin(), more_flags.end());
  process_ = std::make_unique<Process>(flags);
  serving_line_ = process_->WaitForLine("\"event\":\"serving\"");
}

void SecuredCurvd::WriteTokens(const std::string& others) const {
  dir_.Write("tokens", absl::StrCat("the-friend ", FormatHash(HashToken(kFriendsToken)), "\n", others));
}

std::shared_ptr<grpc::Channel> SecuredCurvd::NewChannel(const PemPair& certificate) const {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(
      address(), grpc::SslCredentials({certificates_.authority(), certificate.key, certificate.certificate}),
      arguments);
}

::testing::AssertionResult SecuredCurvd::ServesTheFriend() const {
  return Succeeded(CallWith(FriendsChannel(), kFriendsToken), 1'000);
}

double SecuredCurvd::Strangers(const std::string& reason) const {
  return MetricOf(metrics_port(), absl::StrCat("curvd_strangers_total{reason=\"", reason, "\"}"));
}

void SecuredCurvd::WaitForStrangers(const std::string& reason, double count) const {
  WaitForMetricOf(metrics_port(), absl::StrCat("curvd_strangers_total{reason=\"", reason, "\"}"),
                  [count](double now) { return now >= count; });
}

int SecuredCurvd::PortIn(const std::string& key) const {
  const std::string address = ValueIn(serving_line_, key);
  return std::stoi(address.substr(address.rfind(':') + 1));
}

CallResult CallWith(const std::shared_ptr<grpc::Channel>& channel, const std::string& token, size_t filler) {
  const TestCloud cloud = Sphere(1'000, 1.0f);
  std::vector<std::pair<std::string, std::string>> metadata;
  if (!token.empty()) metadata.emplace_back("authorization", "Bearer " + token);
  if (filler > 0) metadata.emplace_back("filler", std::string(filler, 'x'));
  TestCall call(channel, std::chrono::minutes(1), GRPC_COMPRESS_NONE, metadata);
  if (call.SendHeader(HeaderFor(cloud)) && call.SendCloud(cloud)) call.HalfClose();
  return call.Finish();
}

}  // namespace curvd
