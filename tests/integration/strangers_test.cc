// Those who should stay out: each is refused or bounded, logged, counted, and others keep working.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "proto/access_list.h"
#include "server/rpc/error_reasons.h"
#include "tests/integration/clouds.h"
#include "tests/integration/raw_connections.h"
#include "tests/integration/raw_messages.h"
#include "tests/integration/secured_curvd.h"
#include "tests/integration/test_server.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr auto kUnavailable = grpc::StatusCode::UNAVAILABLE;
constexpr auto kUnauthenticated = grpc::StatusCode::UNAUTHENTICATED;

// Waits until a call has failed for `reason`: its caller may know before the server has counted.
void WaitForFailure(const SecuredCurvd& curvd, const std::string& reason) {
  WaitForMetricOf(curvd.metrics_port(), absl::StrCat("curvd_failures_total{reason=\"", reason, "\"}"),
                  [](double count) { return count == 1; });
}

std::string TokenLine(const std::string& name, const std::string& token, const std::string& limits = "") {
  return absl::StrCat(name, " ", FormatHash(HashToken(token)), " ", limits, "\n");
}

TEST(StrangersTest, WithoutACertificateNobodyComesIn) {
  SecuredCurvd curvd;
  EXPECT_EQ(CallWith(curvd.NewChannel({}), kFriendsToken).status.error_code(), kUnavailable);
  curvd.WaitForStrangers("no_call");
  EXPECT_THAT(curvd.process().WaitForLine("\"event\":\"stranger\""),
              AllOf(HasSubstr("no_call"), HasSubstr("\"peer\":\"ipv4:127.0.0.1:"), HasSubstr("\"received_bytes\":")));
  EXPECT_TRUE(curvd.ServesTheFriend());
}

// What OpenSSL has to say of a handshake comes by itself, without the address of who made it.
TEST(StrangersTest, WhatGrpcSaysOfAHandshakeIsInTheLog) {
  SecuredCurvd curvd;
  EXPECT_EQ(CallWith(curvd.NewChannel({}), kFriendsToken).status.error_code(), kUnavailable);
  EXPECT_THAT(curvd.process().WaitForLine("\"event\":\"grpc\""), HasSubstr("peer did not return a certificate"));
}

TEST(StrangersTest, AnExpiredCertificateIsRefused) {
  SecuredCurvd curvd;
  const PemPair expired = curvd.certificates().Issue("friend", -1);
  EXPECT_EQ(CallWith(curvd.NewChannel(expired), kFriendsToken).status.error_code(), kUnavailable);
  curvd.WaitForStrangers("no_call");
  EXPECT_THAT(curvd.process().WaitForLine("\"event\":\"stranger\""), HasSubstr("\"peer\":\"ipv4:127.0.0.1:"));
  EXPECT_TRUE(curvd.ServesTheFriend());
}

TEST(StrangersTest, ACertificateOfAnotherAuthorityIsRefused) {
  SecuredCurvd curvd;
  const TestCertificates others;
  EXPECT_EQ(CallWith(curvd.NewChannel(others.Issue("friend")), kFriendsToken).status.error_code(), kUnavailable);
  curvd.WaitForStrangers("no_call");
  EXPECT_TRUE(curvd.ServesTheFriend());
}

TEST(StrangersTest, WhoseCallsAreAllRefusedIsAStranger) {
  SecuredCurvd curvd;
  EXPECT_EQ(CallWith(curvd.FriendsChannel(), "a-guessed-token").status.error_code(), kUnauthenticated);
  curvd.WaitForStrangers("not_let_in");
  EXPECT_THAT(curvd.process().WaitForLine("\"event\":\"stranger\""), HasSubstr("not_let_in"));
}

TEST(StrangersTest, NeitherFriendsNorProbesAreStrangers) {
  SecuredCurvd curvd;
  std::string answer;
  EXPECT_TRUE(CheckHealth(curvd.FriendsChannel(), "curvature.v1.CurvatureService", &answer).ok());
  EXPECT_EQ(answer, kServing);
  EXPECT_TRUE(curvd.ServesTheFriend());
  { const RawConnections load_balancer("127.0.0.1", curvd.port(), 3); }
  curvd.WaitForStrangers("nothing_sent", 3);
  WaitForMetricOf(curvd.metrics_port(), "curvd_connections_open", [](double open) { return open == 0; });
  for (const char* reason : {"no_call", "not_let_in", "handshake_timeout"}) EXPECT_EQ(curvd.Strangers(reason), 0);
  curvd.process().Signal(SIGTERM);
  EXPECT_THAT(curvd.process().ReadAll(), Not(HasSubstr("\"event\":\"stranger\"")));
}

// The acceptor must write a peer as gRPC does, whichever way it came.
TEST(StrangersTest, FriendsAreKnownOverBothKindsOfAddresses) {
  const TestServer server([](ServerOptions& options) {
    options.listen = "[::]:0";
    options.insecure = true;
  });
  const std::string port = server.address().substr(server.address().rfind(':'));
  for (const std::string host : {"ipv6:[::1]", "ipv4:127.0.0.1"}) {
    const std::shared_ptr<grpc::Channel> channel = OpenChannel(host + port);
    EXPECT_TRUE(Succeeded(CallWith(channel, ""), 1'000)) << host;
    server.WaitForMetric("curvd_connections_open", 1);
  }
  server.WaitForMetric("curvd_connections_open", 0);
  for (const char* reason : {"no_call", "not_let_in", "nothing_sent", "handshake_timeout"}) {
    EXPECT_EQ(server.Metric(absl::StrCat("curvd_strangers_total{reason=\"", reason, "\"}")), 0) << reason;
  }
}

TEST(StrangersTest, ACertificateWithAnotherNameIsRefused) {
  SecuredCurvd curvd;
  const CallResult result = CallWith(curvd.NewChannel(curvd.certificates().Issue("mallory")), kFriendsToken);
  EXPECT_TRUE(FailedWith(result, grpc::StatusCode::PERMISSION_DENIED, kReasonClientNotAllowed, {"mallory"}));
  EXPECT_THAT(curvd.process().WaitForLine(result.metadata.at("request_id")), HasSubstr(kReasonClientNotAllowed));
  WaitForFailure(curvd, kReasonClientNotAllowed);
  EXPECT_TRUE(curvd.ServesTheFriend());
}

TEST(StrangersTest, WrongAndMissingTokensAreRefusedAndNeverLogged) {
  SecuredCurvd curvd;
  const CallResult wrong = CallWith(curvd.FriendsChannel(), "a-guessed-token");
  EXPECT_TRUE(FailedWith(wrong, kUnauthenticated, kReasonTokenInvalid, {"bearer token"}));
  EXPECT_TRUE(
      FailedWith(CallWith(curvd.FriendsChannel(), ""), kUnauthenticated, kReasonTokenMissing, {"authorization"}));
  WaitForFailure(curvd, kReasonTokenInvalid);
  WaitForFailure(curvd, kReasonTokenMissing);
  EXPECT_TRUE(curvd.ServesTheFriend());
  const std::string metrics = HttpGet(curvd.metrics_port(), "/metrics");
  curvd.process().Signal(SIGTERM);
  const std::string log = curvd.process().ReadAll();
  EXPECT_THAT(log, HasSubstr(kReasonTokenInvalid));
  EXPECT_THAT(log, HasSubstr("\"caller\":\"the-friend\""));
  for (const std::string& secret :
       {std::string("a-guessed-token"), std::string(kFriendsToken), FormatHash(HashToken(kFriendsToken)).substr(7)}) {
    EXPECT_THAT(log, Not(HasSubstr(secret)));
    EXPECT_THAT(metrics, Not(HasSubstr(secret)));
  }
}

TEST(StrangersTest, ServerInfoAsksForATokenToo) {
  SecuredCurvd curvd;
  const auto stub = v1::CurvatureService::NewStub(curvd.FriendsChannel());
  grpc::ClientContext context;
  v1::GetServerInfoResponse info;
  EXPECT_EQ(stub->GetServerInfo(&context, {}, &info).error_code(), kUnauthenticated);
  EXPECT_TRUE(info.version().empty());
  EXPECT_THAT(curvd.process().WaitForLine("\"event\":\"call\""), HasSubstr(kReasonTokenMissing));
}

TEST(StrangersTest, ARevokedTokenStopsWorkingAndEndsItsCalls) {
  SecuredCurvd curvd;
  const std::string token = "curvd_soon_revoked";
  curvd.WriteTokens(TokenLine("bob", token));
  curvd.process().WaitForLine("\"event\":\"reloaded\"");
  TestCall open(curvd.FriendsChannel(), std::chrono::minutes(1), GRPC_COMPRESS_NONE,
                {{"authorization", "Bearer " + token}});
  ASSERT_TRUE(open.SendHeader({}));
  open.ReadAccepted();
  curvd.WriteTokens();
  curvd.process().WaitForLine("\"event\":\"reloaded\"");
  EXPECT_TRUE(FailedWith(open.Finish(), kUnauthenticated, kReasonTokenInvalid, {}));
  EXPECT_TRUE(FailedWith(CallWith(curvd.FriendsChannel(), token), kUnauthenticated, kReasonTokenInvalid, {}));
  EXPECT_TRUE(curvd.ServesTheFriend());
}

TEST(StrangersTest, AFileThatBrokeChangesNothing) {
  SecuredCurvd curvd;
  curvd.dir().Write("tokens", "the-friend not-a-hash\n");
  EXPECT_THAT(curvd.process().WaitForLine("\"event\":\"reload_failed\""), HasSubstr("line 1"));
  EXPECT_EQ(MetricOf(curvd.metrics_port(), "curvd_credential_reloads_total{result=\"failed\"}"), 1);
  curvd.dir().Write("server.key", curvd.certificates().Issue("localhost").key);
  EXPECT_THAT(curvd.process().WaitForLine("\"event\":\"reload_failed\""),
              ContainsRegex("--tls-key [^ ]+server.key, .*: the key is not that of"));
  EXPECT_TRUE(curvd.ServesTheFriend());
  const PemPair ended = curvd.certificates().Issue("localhost", -1);
  curvd.dir().Write("server.key", ended.key);
  curvd.dir().Write("server.crt", ended.certificate);
  EXPECT_THAT(curvd.process().WaitForLine("the certificate ended at"), HasSubstr("\"event\":\"reload_failed\""));
  EXPECT_TRUE(curvd.ServesTheFriend());
}

TEST(StrangersTest, ANewCertificateIsUsedWithoutARestart) {
  SecuredCurvd curvd;
  TestCall open(curvd.FriendsChannel(), std::chrono::minutes(1), GRPC_COMPRESS_NONE,
                {{"authorization", absl::StrCat("Bearer ", kFriendsToken)}});
  ASSERT_TRUE(open.SendHeader({}));
  open.ReadAccepted();
  const TestCertificates next;
  const PemPair server = next.Issue("localhost"), client = next.Issue("friend");
  // In this order: a pair that does not fit yet is not taken.
  curvd.dir().Write("ca.crt", curvd.certificates().authority() + next.authority());
  curvd.dir().Write("server.key", server.key);
  curvd.dir().Write("server.crt", server.certificate);
  const auto channel = [&] {
    return grpc::CreateChannel(curvd.address(),
                               grpc::SslCredentials({next.authority(), client.key, client.certificate}));
  };
  CallResult result = CallWith(channel(), kFriendsToken);
  for (int i = 0; i < 600 && !result.status.ok(); ++i) {
    absl::SleepFor(absl::Milliseconds(100));
    result = CallWith(channel(), kFriendsToken);
  }
  EXPECT_TRUE(Succeeded(result, 1'000));
  open.HalfClose();
  EXPECT_TRUE(Succeeded(open.Finish(), 0));
}

TEST(StrangersTest, PlainTextToTheTlsPortIsRefused) {
  SecuredCurvd curvd;
  const RawConnections stranger("127.0.0.9", curvd.port(), 1);
  stranger.SendAndWaitForClose("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n");
  curvd.WaitForStrangers("no_call");
  EXPECT_THAT(curvd.process().WaitForLine("\"event\":\"stranger\""),
              AllOf(HasSubstr("no_call"), HasSubstr("\"peer\":\"ipv4:127.0.0.9:")));
  const RawConnections browser("127.0.0.1", curvd.port(), 1);
  browser.SendAndWaitForClose("GET / HTTP/1.1\r\nHost: curvd\r\n\r\n");
  curvd.WaitForStrangers("no_call", 2);
  EXPECT_TRUE(curvd.ServesTheFriend());
}

TEST(StrangersTest, AnOversizedHeaderIsRefused) {
  SecuredCurvd curvd;
  const CallResult result = CallWith(curvd.FriendsChannel(), kFriendsToken, 10'000);
  // RESOURCE_EXHAUSTED, unless what the client still writes breaks first.
  EXPECT_FALSE(result.status.ok());
  curvd.WaitForStrangers("no_call");  // gRPC refuses the call before anybody sees it
  EXPECT_TRUE(Succeeded(CallWith(curvd.FriendsChannel(), kFriendsToken, 4'000), 1'000));
}

TEST(StrangersTest, MetadataOfTheSizeThatTheOptionAllowsIsLetIn) {
  SecuredCurvd curvd({"--max-header-bytes=1048576"});
  EXPECT_TRUE(Succeeded(CallWith(curvd.FriendsChannel(), kFriendsToken, 1'000'000), 1'000));
}

TEST(StrangersTest, ConnectionsThatSayNothingAreBoundedAndLeaveRoomForOthers) {
  SecuredCurvd curvd({"--max-connections=80", "--max-connections-per-peer=40", "--handshake-timeout=1h"});
  const RawConnections crowd("127.0.0.2", curvd.port(), 300);
  curvd.WaitForStrangers("peer_connection_limit", 260);
  EXPECT_EQ(crowd.CountOpen(), 40u);
  EXPECT_THAT(curvd.process().WaitForLine("\"event\":\"stranger\""),
              AllOf(HasSubstr("peer_connection_limit"), HasSubstr("ipv4:127.0.0.2:")));
  EXPECT_TRUE(curvd.ServesTheFriend());
  // The friend has hung up: else that connection would count among the 80, and be missed later.
  WaitForMetricOf(curvd.metrics_port(), "curvd_connections_open", [](double open) { return open == 40; });
  const RawConnections second_crowd("127.0.0.3", curvd.port(), 40), third_crowd("127.0.0.4", curvd.port(), 40);
  curvd.WaitForStrangers("connection_limit");
  WaitForMetricOf(curvd.metrics_port(), "curvd_connections_open", [](double open) { return open == 80; });
}

TEST(StrangersTest, ConnectionsThatSayNothingAreClosedAfterAWhile) {
  SecuredCurvd curvd({"--handshake-timeout=200ms"});
  const RawConnections crowd("127.0.0.2", curvd.port(), 50);
  curvd.WaitForStrangers("handshake_timeout", 50);
  WaitForMetricOf(curvd.metrics_port(), "curvd_connections_open", [](double open) { return open == 0; });
  EXPECT_EQ(crowd.CountOpen(), 0u);
  EXPECT_TRUE(curvd.ServesTheFriend());
}

TEST(StrangersTest, ConnectionsWithoutACallAreClosedAfterAWhile) {
  SecuredCurvd curvd({"--idle-timeout=300ms"});
  const std::shared_ptr<grpc::Channel> channel = curvd.FriendsChannel();
  EXPECT_TRUE(Succeeded(CallWith(channel, kFriendsToken), 1'000));
  WaitForMetricOf(curvd.metrics_port(), "curvd_connections_open", [](double open) { return open == 0; });
  // Nobody reads a channel that has no call: it may notice only now, and connects again then.
  CallResult again = CallWith(channel, kFriendsToken);
  if (again.status.error_code() == kUnavailable) again = CallWith(channel, kFriendsToken);
  EXPECT_TRUE(Succeeded(again, 1'000));
}

TEST(StrangersTest, ATokensLimitsHoldForItsCalls) {
  SecuredCurvd curvd;
  const std::string token = "curvd_limited";
  curvd.WriteTokens(TokenLine("bob", token, "max-points=500 max-streams=1"));
  curvd.process().WaitForLine("\"event\":\"reloaded\"");
  const auto channel = curvd.FriendsChannel();
  EXPECT_TRUE(
      FailedWith(CallWith(channel, token), grpc::StatusCode::RESOURCE_EXHAUSTED, kReasonTooManyPoints, {"500"}));
  TestCall open(channel, std::chrono::minutes(1), GRPC_COMPRESS_NONE, {{"authorization", "Bearer " + token}});
  ASSERT_TRUE(open.SendHeader({}));
  EXPECT_EQ(open.ReadAccepted().limits().max_points(), 500u);
  const CallResult second = CallWith(channel, token);
  EXPECT_TRUE(FailedWith(second, grpc::StatusCode::RESOURCE_EXHAUSTED, kReasonPeerStreamLimit, {"bob", "below 1"}));
  EXPECT_TRUE(second.retry_seconds.has_value());
  EXPECT_TRUE(curvd.ServesTheFriend());
  open.HalfClose();
  EXPECT_TRUE(Succeeded(open.Finish(), 0));
}

TEST(StrangersTest, ProbesLearnOfHealthAndOfNothingElse) {
  SecuredCurvd curvd;
  const auto channel = OpenChannel(absl::StrCat("127.0.0.1:", curvd.health_port()));
  grpc::ClientContext context;
  v1::GetServerInfoResponse info;
  const auto stub = v1::CurvatureService::NewStub(channel);
  EXPECT_EQ(stub->GetServerInfo(&context, {}, &info).error_code(), grpc::StatusCode::UNIMPLEMENTED);
  std::string answer;
  EXPECT_TRUE(CheckHealth(channel, "curvature.v1.CurvatureService", &answer).ok());
  EXPECT_EQ(answer, kServing);
}

// Each of their calls is some 150 bytes, and a connection may send 96 KiB that nothing accounts for, on the port of
// probes 32 KiB.
TEST(StrangersTest, ProbesThatKeepTheirConnectionAreServedForLong) {
  SecuredCurvd curvd;
  const auto probes = OpenChannel(absl::StrCat("127.0.0.1:", curvd.health_port()));
  for (const auto& channel : {probes, curvd.FriendsChannel()}) {
    for (int probe = 0; probe < 2'000; ++probe) {
      std::string answer;
      const grpc::Status status = CheckHealth(channel, "", &answer);
      ASSERT_TRUE(status.ok()) << probe << ": " << status.error_message();
    }
  }
  EXPECT_EQ(curvd.Strangers("unaccounted_bytes"), 0);
}

}  // namespace
}  // namespace curvd
