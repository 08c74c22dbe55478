// What a server offers beside the estimate: its description, health, reflection, metrics, and where it listens.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <string>
#include <thread>

#include "absl/strings/str_cat.h"
#include "tests/integration/clouds.h"
#include "tests/integration/raw_messages.h"
#include "tests/integration/test_call.h"
#include "tests/integration/test_server.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(ServerInfoTest, TellsVersionLimitsEstimatorsAndThreads) {
  TestServer server([](ServerOptions& options) {
    options.threads = 3;
    options.max_points = 12'345;
    options.memory_limit_bytes = 1 << 30;
  });
  const auto stub = v1::CurvatureService::NewStub(server.NewChannel());
  grpc::ClientContext context;
  v1::GetServerInfoResponse info;
  ASSERT_TRUE(stub->GetServerInfo(&context, {}, &info).ok());
  EXPECT_THAT(info.version(), ::testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+"));
  EXPECT_EQ(info.limits().max_points(), 12'345u);
  EXPECT_EQ(info.limits().memory_bytes(), 1u << 30);
  EXPECT_EQ(info.estimators_size(), 9);
  EXPECT_EQ(info.worker_threads(), 3u);
  EXPECT_FALSE(info.cpu_kind().empty());
}

TEST(HealthTest, KnowsTheServerAndTheService) {
  TestServer server;
  const std::shared_ptr<grpc::Channel> channel = server.NewChannel();
  std::string answer;
  EXPECT_TRUE(CheckHealth(channel, "", &answer).ok());
  EXPECT_EQ(answer, kServing);
  EXPECT_TRUE(CheckHealth(channel, "curvature.v1.CurvatureService", &answer).ok());
  EXPECT_EQ(answer, kServing);
  EXPECT_EQ(CheckHealth(channel, "no.such.Service", &answer).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST(HealthTest, SaysNotServingWhileDraining) {
  TestServer server;
  const std::shared_ptr<grpc::Channel> channel = server.NewChannel();
  TestCall open(channel);
  ASSERT_TRUE(open.SendHeader({}));
  open.ReadAccepted();
  std::thread drain([&] { server.server().Drain(absl::Minutes(1)); });
  server.WaitForMetric("curvd_draining", 1);
  for (const char* service : {"", "curvature.v1.CurvatureService"}) {
    std::string answer;
    EXPECT_TRUE(CheckHealth(channel, service, &answer).ok());
    EXPECT_EQ(answer, kNotServing) << service;
  }
  open.HalfClose();
  EXPECT_TRUE(Succeeded(open.Finish(), 0));
  drain.join();
}

TEST(ReflectionTest, ListsTheServices) {
  TestServer server;
  const std::shared_ptr<grpc::Channel> channel = server.NewChannel();
  grpc::ClientContext context;
  const grpc::internal::RpcMethod method("/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
                                         grpc::internal::RpcMethod::BIDI_STREAMING, channel);
  std::unique_ptr<grpc::ClientReaderWriter<grpc::ByteBuffer, grpc::ByteBuffer>> stream(
      grpc::internal::ClientReaderWriterFactory<grpc::ByteBuffer, grpc::ByteBuffer>::Create(channel.get(), method,
                                                                                            &context));
  constexpr int kListServices = 7;
  ASSERT_TRUE(stream->Write(BufferOf(StringField(kListServices, "*"))));
  grpc::ByteBuffer answer;
  ASSERT_TRUE(stream->Read(&answer));
  EXPECT_THAT(BytesOf(answer), HasSubstr("curvature.v1.CurvatureService"));
  EXPECT_THAT(BytesOf(answer), HasSubstr("grpc.health.v1.Health"));
  stream->WritesDone();
  EXPECT_TRUE(stream->Finish().ok());
}

TEST(MetricsTest, AScrapeHasEveryName) {
  TestServer server;
  const TestCloud cloud = Sphere(1'000, 1.0f);
  ASSERT_TRUE(Succeeded(Estimate(server.NewChannel(), HeaderFor(cloud), cloud), cloud.size()));
  server.WaitUntilIdle();
  const std::string text = server.Scrape();
  for (const char* name : {"grpc_server_started_total",
                           "grpc_server_handled_total",
                           "grpc_server_handling_seconds_bucket",
                           "grpc_server_msg_received_total",
                           "grpc_server_msg_sent_total",
                           "curvd_points_total",
                           "curvd_received_bytes_total",
                           "curvd_sent_bytes_total",
                           "curvd_phase_seconds_bucket",
                           "curvd_queue_jobs",
                           "curvd_workers",
                           "curvd_workers_busy",
                           "curvd_memory_reserved_bytes",
                           "curvd_memory_limit_bytes",
                           "curvd_streams_open",
                           "curvd_failures_total",
                           "curvd_build_info",
                           "curvd_queue_limit_jobs",
                           "curvd_streams_limit",
                           "curvd_cloud_points_bucket",
                           "curvd_log_lines_lost_total",
                           "process_resident_memory_bytes",
                           "process_open_fds"}) {
    EXPECT_THAT(text, HasSubstr(absl::StrCat("\n", name)));
  }
  EXPECT_EQ(server.Metric("curvd_points_total{status=\"ok\"}"), 1'000.0);
  EXPECT_EQ(server.Metric("curvd_phase_seconds_count{phase=\"estimate\"}"), 1.0);
  EXPECT_GT(server.Metric("curvd_received_bytes_total"), 24'000.0);
  EXPECT_GT(server.Metric("curvd_sent_bytes_total"), 45'000.0);
}

// Whoever may scrape or check health is not the caller.
TEST(MetricsTest, NeitherMetricsNorHealthTellTagsOrRequestIds) {
  TestServer server;
  const TestCloud cloud = Sphere(100, 1.0f);
  v1::CloudHeader header = HeaderFor(cloud);
  header.set_request_tag("patient-4711");
  TestCall call(server.NewChannel());
  ASSERT_TRUE(call.SendHeader(header));
  const std::string request_id = call.ReadAccepted().request_id();
  ASSERT_FALSE(request_id.empty());
  std::string health;
  EXPECT_TRUE(CheckHealth(server.NewChannel(), "", &health).ok());
  for (const std::string& text : {server.Scrape(), health}) {
    EXPECT_THAT(text, Not(HasSubstr("4711")));
    EXPECT_THAT(text, Not(HasSubstr(request_id)));
  }
}

TEST(ListenTest, ASecondServerOnThePortFailsWithItsName) {
  TestServer first;
  ServerOptions options;
  options.listen = first.address();
  options.metrics_listen = "";
  const auto second = CurvatureServer::Create(options);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(second.status().message()), HasSubstr(first.address()));
}

TEST(ListenTest, ASecondServerOnTheMetricsPortFailsWithItsName) {
  TestServer first;
  ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.metrics_listen = absl::StrCat("127.0.0.1:", first.server().metrics_port());
  const auto second = CurvatureServer::Create(options);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(second.status().message()), HasSubstr(options.metrics_listen));
}

TEST(ListenTest, ServesOnAUnixSocket) {
  const std::string path = absl::StrCat(::testing::TempDir(), "/curvd_", getpid(), ".sock");
  TestServer server([&](ServerOptions& options) { options.listen = "unix:" + path; });
  EXPECT_EQ(server.server().port(), 0);
  const TestCloud cloud = Sphere(100, 1.0f);
  EXPECT_TRUE(Succeeded(Estimate(OpenChannel("unix:" + path), HeaderFor(cloud), cloud), 100));
}

TEST(ListenTest, ServesWithoutAnyPort) {
  TestServer server([](ServerOptions& options) { options.listen = options.metrics_listen = ""; });
  EXPECT_EQ(server.server().port(), 0);
  EXPECT_EQ(server.server().metrics_port(), 0);
  const TestCloud cloud = Sphere(100, 1.0f);
  EXPECT_TRUE(Succeeded(Estimate(server.server().InProcessChannel(), HeaderFor(cloud), cloud), 100));
}

TEST(ListenTest, OptionsOutOfRangeAreRefused) {
  ServerOptions options;
  options.max_streams = 0;
  EXPECT_EQ(CurvatureServer::Create(options).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace curvd
