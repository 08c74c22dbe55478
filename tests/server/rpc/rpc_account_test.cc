#include "server/rpc/rpc_account.h"

#include <gtest/gtest.h>

#include "server/rpc/error_reasons.h"
#include "tests/server/rpc/test_service.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

using std::chrono::system_clock;

constexpr char kInfoLabels[] =
    "grpc_method=\"GetServerInfo\",grpc_service=\"curvature.v1.CurvatureService\",grpc_type=\"unary\"}";

class RpcAccountTest : public ::testing::Test {
 protected:
  double Count(const std::string& series) { return MetricOf(service_.metrics, series); }

  ServiceContext service_{TestServiceOptions()};
};

TEST_F(RpcAccountTest, CountsAnRpcFromItsStartToItsEnd) {
  RpcAccount account(service_, RpcMethod::kGetServerInfo, ArrivalFrom("ipv4:10.0.0.7:1234"));
  EXPECT_EQ(Count(absl::StrCat("grpc_server_started_total{", kInfoLabels)), 1);
  account.CountReceived(10);
  account.CountReceived(20);
  account.CountSent(5);
  EXPECT_EQ(account.record().bytes_received, 30u);
  EXPECT_EQ(account.record().bytes_sent, 5u);
  EXPECT_EQ(Count(absl::StrCat("grpc_server_msg_received_total{", kInfoLabels)), 2);
  EXPECT_EQ(Count(absl::StrCat("grpc_server_msg_sent_total{", kInfoLabels)), 1);
  EXPECT_EQ(Count(absl::StrCat("grpc_server_handled_total{grpc_code=\"OK\",", kInfoLabels)), 0);
  account.Close(absl::OkStatus());
  EXPECT_EQ(Count(absl::StrCat("grpc_server_handled_total{grpc_code=\"OK\",", kInfoLabels)), 1);
}

TEST_F(RpcAccountTest, OnlyAnEstimateHasACloud) {
  RpcAccount(service_, RpcMethod::kGetServerInfo, ArrivalFrom("unix:")).Close(absl::OkStatus());
  EXPECT_EQ(Count("curvd_cloud_points_count"), 0);
  RpcAccount(service_, RpcMethod::kEstimateCurvature, ArrivalFrom("unix:")).Close(absl::OkStatus());
  EXPECT_EQ(Count("curvd_cloud_points_count"), 1);
}

TEST_F(RpcAccountTest, FindsOutWhoCalls) {
  service_.access.SetTokens(OneToken("alice"));
  RpcArrival arrival = ArrivalFrom("ipv4:10.0.0.7:1234");
  arrival.presented.authorization = "Bearer secret";
  RpcAccount account(service_, RpcMethod::kGetServerInfo, arrival);
  ASSERT_TRUE(account.caller().ok());
  EXPECT_EQ(account.caller()->name, "alice");
  EXPECT_EQ(account.record().caller, "alice");
  EXPECT_EQ(account.record().peer, "ipv4:10.0.0.7:1234");
  account.Close(absl::OkStatus());
}

TEST_F(RpcAccountTest, ACallerThatIsNotLetInCountsAsAFailureWithItsReason) {
  service_.access.SetTokens(OneToken("alice"));
  RpcAccount account(service_, RpcMethod::kGetServerInfo, ArrivalFrom("ipv4:10.0.0.7:1234"));
  ASSERT_TRUE(IsError(account.caller().status(), absl::StatusCode::kUnauthenticated, kReasonTokenMissing, {}));
  const grpc::Status status = account.ToCaller(account.caller().status());
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAUTHENTICATED);
  EXPECT_NE(status.error_message().find(account.request_id()), std::string::npos);
  account.Close(account.caller().status());
  EXPECT_EQ(Count("curvd_failures_total{reason=\"TOKEN_MISSING\"}"), 1);
  EXPECT_EQ(Count(absl::StrCat("grpc_server_handled_total{grpc_code=\"UNAUTHENTICATED\",", kInfoLabels)), 1);
}

TEST_F(RpcAccountTest, EveryRpcHasAnIdOfItsOwn) {
  const RpcAccount first(service_, RpcMethod::kGetServerInfo, ArrivalFrom("unix:"));
  const RpcAccount second(service_, RpcMethod::kGetServerInfo, ArrivalFrom("unix:"));
  EXPECT_NE(first.request_id(), second.request_id());
}

TEST_F(RpcAccountTest, TellsACancelFromADeadlineThatHasPassed) {
  RpcArrival arrival = ArrivalFrom("unix:");
  EXPECT_TRUE(absl::IsCancelled(RpcAccount(service_, RpcMethod::kGetServerInfo, arrival).CallerGoneNow()));
  arrival.deadline = system_clock::now() + std::chrono::hours(1);
  EXPECT_TRUE(absl::IsCancelled(RpcAccount(service_, RpcMethod::kGetServerInfo, arrival).CallerGoneNow()));
  arrival.deadline = system_clock::now();
  EXPECT_TRUE(absl::IsDeadlineExceeded(RpcAccount(service_, RpcMethod::kGetServerInfo, arrival).CallerGoneNow()));
}

}  // namespace
}  // namespace curvd
