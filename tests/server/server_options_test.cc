#include "server/server_options.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "server/rpc/error_reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

TEST(ServerOptionsTest, DefaultsAreValid) { EXPECT_TRUE(ServerOptions().Validate().ok()); }

TEST(ServerOptionsTest, RefusesPortsThatThereAreNot) {
  const std::pair<const char*, std::string ServerOptions::*> addresses[] = {
      {"--listen", &ServerOptions::listen},
      {"--health-listen", &ServerOptions::health_listen},
      {"--metrics-listen", &ServerOptions::metrics_listen}};
  for (const auto& [flag, member] : addresses) {
    for (const char* address :
         {"127.0.0.1:120540", "127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:", "127.0.0.1:http", ":9461",
          "[::1]:99999999999999999999", "127.0.0.1:+1", "127.0.0.1: 1", "127.0.0.1:0x10"}) {
      ServerOptions options;
      options.*member = address;
      EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {flag, address, "[0, 65535]"}));
    }
    for (const char* address : {"127.0.0.1:0", "127.0.0.2:65535", "localhost:00080", ""}) {
      ServerOptions options;
      options.*member = address;
      EXPECT_TRUE(options.Validate().ok()) << flag << ' ' << options.Validate();
    }
  }
}

TEST(ServerOptionsTest, RefusesAddressesWhereNoScrapesCanBeAnswered) {
  for (const char* address : {"[::1]:9461", "::1:9461", "*:9461", "unix:/run/curvd.sock", "unix:80"}) {
    ServerOptions options;
    options.metrics_listen = address;
    EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--metrics-listen", address, "IPv4"}));
    options = {};
    options.health_listen = address;
    EXPECT_TRUE(options.Validate().ok()) << options.Validate();
  }
}

TEST(ServerOptionsTest, NamesFlagValueAndLimitOfWhatIsOutOfRange) {
  ServerOptions options;
  options.threads = -1;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--threads", "-1", "[0, 4096]"}));
  options = {};
  options.max_points = 0;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--max-points", "0", "2147483647"}));
  options = {};
  options.max_chunk_bytes = 1;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--max-chunk-bytes", "1024"}));
  options = {};
  options.max_neighbor_count = 3;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--max-neighbor-count", "3"}));
  options = {};
  options.memory_limit_bytes = 1000;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--memory-limit", "1000", "33554432"}));
  options = {};
  options.max_streams = 0;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--max-streams", "0"}));
  options = {};
  options.max_waiting = 100'001;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--max-waiting", "100001"}));
  options = {};
  options.drain_timeout = -absl::Seconds(1);
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--drain-timeout", "-1s"}));
  options = {};
  options.stall_timeout = absl::ZeroDuration();
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--stall-timeout", "above 0s"}));
  options = {};
  options.max_streams_per_peer = 0;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--max-streams-per-peer", "0"}));
  options = {};
  options.max_connections = 0;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--max-connections", "0"}));
  options = {};
  options.max_connections_per_peer = 0;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--max-connections-per-peer", "0"}));
  options = {};
  options.max_header_bytes = 100;
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--max-header-bytes", "100"}));
  options = {};
  options.idle_timeout = absl::ZeroDuration();
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--idle-timeout", "above 0s"}));
  options = {};
  options.handshake_timeout = absl::ZeroDuration();
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--handshake-timeout", "above 0s"}));
}

TEST(ServerOptionsTest, OtherMachinesReachItOnlyWithTlsOrIfTheOperatorInsists) {
  ServerOptions options;
  for (const char* listen : {"0.0.0.0:1", "[::]:1", "10.0.0.7:1", "curvd.example:1", "127.example:1"}) {
    options.listen = listen;
    EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--listen", listen, "--insecure"}));
  }
  options.insecure = true;
  EXPECT_TRUE(options.Validate().ok());
  options.insecure = false;
  options.tls_cert = "server.crt";
  options.tls_key = "server.key";
  EXPECT_TRUE(options.Validate().ok());
}

TEST(ServerOptionsTest, WhatBelongsTogetherIsGivenTogether) {
  ServerOptions options;
  options.tls_cert = "server.crt";
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--tls-cert", "--tls-key"}));
  options = {};
  options.tls_key = "server.key";
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--tls-key", "--tls-cert"}));
  options = {};
  options.tls_client_ca = "ca.crt";
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--tls-client-ca", "--tls-cert"}));
  options = {};
  options.tls_client_names = "names";
  EXPECT_TRUE(IsError(options.Validate(), kInvalid, kReasonInvalidOption, {"--tls-client-names", "--tls-client-ca"}));
}

}  // namespace
}  // namespace curvd
