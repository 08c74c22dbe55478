// Calls that end early, many calls at once, and the end of the server.
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "server/rpc/error_reasons.h"
#include "tests/integration/clouds.h"
#include "tests/integration/raw_http2_call.h"
#include "tests/integration/test_call.h"
#include "tests/integration/test_server.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using grpc::StatusCode;
using std::chrono::milliseconds;

constexpr char kHandled[] = "grpc_server_handled_total{grpc_code=\"";
constexpr char kMethod[] =
    "\",grpc_method=\"EstimateCurvature\",grpc_service=\"curvature.v1.CurvatureService\",grpc_type=\"bidi_stream\"}";

constexpr char kReceivedSeries[] =
    "grpc_server_msg_received_total{grpc_method=\"EstimateCurvature\","
    "grpc_service=\"curvature.v1.CurvatureService\",grpc_type=\"bidi_stream\"}";

std::string HandledSeries(const std::string& code) { return kHandled + code + kMethod; }

// Minutes of work, so that there is time to end it.
v1::CloudHeader SlowHeader(const TestCloud& cloud) {
  v1::CloudHeader header = HeaderFor(cloud, 5'000);
  header.mutable_options()->set_estimator(v1::ESTIMATOR_UNIFORM);
  header.mutable_options()->set_triangle_count(10'000);
  return header;
}

// How many calls came to `phase`.
std::string PhaseSeries(const char* phase) { return absl::StrCat("curvd_phase_seconds_count{phase=\"", phase, "\"}"); }

void WaitForPhase(TestCall& call, v1::Progress::Phase phase) {
  for (;;) {
    const auto message = call.ReadAny();
    ASSERT_TRUE(message.has_value());
    if (message->has_progress() && message->progress().phase() == phase) return;
  }
}

TEST(LifecycleTest, CancelWhileReceiving) {
  TestServer server;
  TestCall call(server.NewChannel());
  const TestCloud cloud = Sphere(1'000, 1.0f);
  ASSERT_TRUE(call.SendHeader(HeaderFor(cloud)));
  ASSERT_TRUE(call.SendPoints(cloud, 0, 500));
  call.ReadAccepted();
  server.WaitForMetric(kReceivedSeries, 2);  // a call that ends before it gets memory has received nothing
  call.Cancel();
  EXPECT_EQ(call.Finish().status.error_code(), StatusCode::CANCELLED);
  server.WaitForMetric(HandledSeries("CANCELLED"), 1);
  server.WaitForMetric("curvd_failures_total{reason=\"CANCELLED\"}", 1);
  server.WaitForMetric(PhaseSeries("receive"), 1);
  EXPECT_EQ(server.Metric(PhaseSeries("queue")), 0);
  server.WaitUntilIdle();
}

TEST(LifecycleTest, CancelWhileEstimatingFreesTheWorkers) {
  TestServer server;
  TestCall call(server.NewChannel());
  const TestCloud cloud = Sphere(200'000, 1.0f);
  ASSERT_TRUE(call.SendHeader(SlowHeader(cloud)));
  ASSERT_TRUE(call.SendCloud(cloud));
  call.HalfClose();
  WaitForPhase(call, v1::Progress::PHASE_ESTIMATING);
  call.Cancel();
  EXPECT_EQ(call.Finish().status.error_code(), StatusCode::CANCELLED);
  server.WaitForMetric(HandledSeries("CANCELLED"), 1);
  server.WaitForMetric(PhaseSeries("estimate"), 1);
  EXPECT_EQ(server.Metric(PhaseSeries("send")), 0);
  server.WaitUntilIdle();
}

// Another large job has as many turns to come as the cancelled one: its memory is not held until they are over.
TEST(LifecycleTest, ACancelledJobDoesNotHoldMemoryWhileOthersWork) {
  TestServer server;
  const TestCloud cloud = Sphere(200'000, 1.0f);
  std::vector<std::unique_ptr<TestCall>> calls;
  for (int i = 0; i < 2; ++i) {
    calls.push_back(std::make_unique<TestCall>(server.NewChannel()));
    ASSERT_TRUE(calls.back()->SendHeader(SlowHeader(cloud)));
    ASSERT_TRUE(calls.back()->SendCloud(cloud));
    calls.back()->HalfClose();
    WaitForPhase(*calls.back(), v1::Progress::PHASE_ESTIMATING);
  }
  const double both = server.Metric("curvd_memory_reserved_bytes");
  calls.back()->Cancel();
  server.WaitForMetric("curvd_memory_reserved_bytes", both / 2);
  calls.front()->Cancel();
  for (const auto& call : calls) EXPECT_EQ(call->Finish().status.error_code(), StatusCode::CANCELLED);
  server.WaitUntilIdle();
}

TEST(LifecycleTest, CancelWhileSending) {
  TestServer server;
  TestCall call(server.NewChannel());
  const TestCloud cloud = Sphere(300'000, 1.0f);
  ASSERT_TRUE(call.SendHeader(HeaderFor(cloud, 4)));
  ASSERT_TRUE(call.SendCloud(cloud));
  call.HalfClose();
  call.ReadAccepted();
  const auto first = call.Read();
  ASSERT_TRUE(first.has_value());
  EXPECT_TRUE(first->has_result());
  call.Cancel();
  EXPECT_EQ(call.Finish().status.error_code(), StatusCode::CANCELLED);
  server.WaitForMetric(HandledSeries("CANCELLED"), 1);
  server.WaitForMetric(PhaseSeries("send"), 1);
  server.WaitUntilIdle();
}

TEST(LifecycleTest, DeadlineEndsTheWork) {
  TestServer server;
  TestCall call(server.NewChannel(), milliseconds(700));
  const TestCloud cloud = Sphere(200'000, 1.0f);
  ASSERT_TRUE(call.SendHeader(SlowHeader(cloud)));
  call.SendCloud(cloud);  // where the machine is busy, the deadline may pass meanwhile
  call.HalfClose();
  EXPECT_EQ(call.Finish().status.error_code(), StatusCode::DEADLINE_EXCEEDED);
  server.WaitUntilIdle();
  // The server's clock of the deadline starts when the call arrives: the client's cancel may come first.
  EXPECT_EQ(server.Metric(HandledSeries("DEADLINE_EXCEEDED")) + server.Metric(HandledSeries("CANCELLED")), 1.0);
}

TEST(LifecycleTest, AReaderThatStopsHoldsUpNobodyAndIsEnded) {
  TestServer server([](ServerOptions& options) { options.stall_timeout = absl::Milliseconds(600); });
  TestCall stalled(server.NewChannel());
  const TestCloud cloud = Sphere(500'000, 1.0f);
  ASSERT_TRUE(stalled.SendHeader(HeaderFor(cloud, 4)));
  stalled.SendCloud(cloud);  // where the machine is busy, even this may seem stalled
  stalled.HalfClose();
  const TestCloud other = Sphere(10'000, 1.0f);
  EXPECT_TRUE(Succeeded(Estimate(server.NewChannel(), HeaderFor(other), other), other.size()));
  server.WaitForMetric("curvd_failures_total{reason=\"STALLED\"}", 1);
  server.WaitUntilIdle();
  EXPECT_FALSE(stalled.Finish().status.ok());
}

// The status waits behind Accepted, for which there is no room: such a call held its memory as long as its peer liked.
TEST(LifecycleTest, ACallThatFailedIsEndedAlsoIfItsReaderTakesNothing) {
  TestServer server([](ServerOptions& options) { options.stall_timeout = absl::Milliseconds(300); });
  RawHttp2Call call(server.server().port(), 0);
  v1::EstimateCurvatureRequest header;
  header.mutable_header()->set_point_count(1'000'000);
  call.SendBytes(RawHttp2Call::Framed(header));
  call.SendBytes(RawHttp2Call::Framed(header));
  server.WaitForMetric(kReceivedSeries, 2);
  EXPECT_EQ(server.Metric("curvd_streams_open"), 1);
  server.WaitUntilIdle();
}

TEST(LifecycleTest, ASenderThatStopsIsEnded) {
  // Long enough for the call's end to leave a busy machine: what does not is cut off after as long.
  TestServer server([](ServerOptions& options) { options.stall_timeout = absl::Seconds(1); });
  TestCall call(server.NewChannel());
  ASSERT_TRUE(call.SendHeader({}));
  EXPECT_TRUE(FailedWith(call.Finish(), StatusCode::DEADLINE_EXCEEDED, kReasonStalled,
                         {"time without a message", "1s", "stall_timeout"}));
  server.WaitUntilIdle();
}

TEST(LifecycleTest, ThirtyTwoStreamsAtOnceGetTheSameBytes) {
  TestServer server;
  const TestCloud cloud = Torus(20'000);
  const CallResult expected = Estimate(server.NewChannel(), HeaderFor(cloud), cloud);
  ASSERT_TRUE(Succeeded(expected, cloud.size()));
  const std::shared_ptr<grpc::Channel> channel = server.NewChannel();
  std::vector<CallResult> results(32);
  std::vector<std::thread> clients;
  clients.reserve(results.size());
  for (CallResult& result : results) {
    clients.emplace_back([&, &result = result] { result = Estimate(channel, HeaderFor(cloud), cloud, 3'000); });
  }
  for (std::thread& client : clients) client.join();
  for (const CallResult& result : results) {
    ASSERT_TRUE(Succeeded(result, cloud.size()));
    EXPECT_TRUE(result.AllBytes() == expected.AllBytes());
  }
  server.WaitUntilIdle();
  EXPECT_EQ(server.Metric("curvd_points_total{status=\"ok\"}"), 33 * 20'000.0);
}

// Runs a call up to step `end` of 6, and cancels it there.
void CancelAtStep(const std::shared_ptr<grpc::Channel>& channel, const TestCloud& cloud, size_t end) {
  TestCall call(channel);
  v1::CloudHeader header = HeaderFor(cloud);
  if (end % 2 == 1) header.clear_point_count();
  if (end > 0) call.SendHeader(header);
  if (end > 1) call.ReadAccepted();
  if (end > 2) call.SendPoints(cloud, 0, cloud.size() / 2);
  if (end > 3) call.SendPoints(cloud, cloud.size() / 2, cloud.size() - cloud.size() / 2);
  if (end > 4) call.HalfClose();
  if (end > 5) call.Read();
  call.Cancel();
  const grpc::Status status = call.Finish().status;
  EXPECT_TRUE(status.ok() || status.error_code() == StatusCode::CANCELLED)
      << status.error_code() << ": " << status.error_message();
}

TEST(LifecycleTest, ManyCancelsLeaveEverythingWhereItWas) {
  TestServer server;
  const TestCloud cloud = Sphere(20'000, 1.0f);
  constexpr size_t kClients = 8, kCancelsEach = 35;
  std::vector<std::thread> clients;
  clients.reserve(kClients);
  for (size_t client = 0; client < kClients; ++client) {
    clients.emplace_back([&server, &cloud, client] {
      const std::shared_ptr<grpc::Channel> channel = server.NewChannel();
      // Of many channels that connect at once gRPC 1.51 fails one at times, with an errno of something else, and all of
      // its calls until it tries again.
      ASSERT_TRUE(channel->WaitForConnected(std::chrono::system_clock::now() + std::chrono::seconds(30)));
      for (size_t i = 0; i < kCancelsEach; ++i) CancelAtStep(channel, cloud, (client + i) % 7);
    });
  }
  for (std::thread& client : clients) client.join();
  server.WaitUntilIdle();
  EXPECT_EQ(server.Metric("curvd_failures_total{reason=\"INTERNAL\"}"), 0.0);
  EXPECT_TRUE(Succeeded(Estimate(server.NewChannel(), HeaderFor(cloud), cloud), cloud.size()));
}

// Starts a drain on a thread, and returns once the server takes no new call.
class Drain {
 public:
  Drain(TestServer& server, absl::Duration timeout) : thread_([&server, timeout] { server.server().Drain(timeout); }) {
    server.WaitForMetric("curvd_draining", 1);
  }
  ~Drain() { thread_.join(); }

 private:
  std::thread thread_;
};

TEST(LifecycleTest, DrainLetsAcceptedCallsFinishAndRefusesNewOnes) {
  TestServer server;
  const TestCloud cloud = Sphere(5'000, 1.0f);
  const std::shared_ptr<grpc::Channel> channel = server.NewChannel();
  std::vector<std::unique_ptr<TestCall>> calls;
  for (int i = 0; i < 8; ++i) {
    calls.push_back(std::make_unique<TestCall>(channel));
    ASSERT_TRUE(calls.back()->SendHeader(HeaderFor(cloud)));
    calls.back()->ReadAccepted();
  }
  Drain drain(server, absl::Seconds(60));
  EXPECT_TRUE(FailedWith(Estimate(channel, HeaderFor(cloud), cloud), StatusCode::UNAVAILABLE, kReasonDraining,
                         {"draining", "another replica"}));
  for (const auto& call : calls) {
    ASSERT_TRUE(call->SendCloud(cloud, 700));
    call->HalfClose();
    EXPECT_TRUE(Succeeded(call->Finish(), cloud.size()));
  }
}

TEST(LifecycleTest, DrainEndsWhatDoesNotFinishInTime) {
  TestServer server;
  const std::shared_ptr<grpc::Channel> channel = server.NewChannel();
  TestCall receiving(channel);
  ASSERT_TRUE(receiving.SendHeader({}));
  receiving.ReadAccepted();
  TestCall estimating(channel);
  const TestCloud cloud = Sphere(200'000, 1.0f);
  ASSERT_TRUE(estimating.SendHeader(SlowHeader(cloud)));
  ASSERT_TRUE(estimating.SendCloud(cloud));
  estimating.HalfClose();
  WaitForPhase(estimating, v1::Progress::PHASE_ESTIMATING);
  server.server().Drain(absl::Milliseconds(100));
  for (TestCall* call : {&receiving, &estimating}) {
    EXPECT_TRUE(FailedWith(call->Finish(), StatusCode::UNAVAILABLE, kReasonDrainTimeout,
                           {"draining", "100ms", "drain_timeout", "another replica"}));
  }
  server.server().Wait();
}

TEST(LifecycleTest, DrainOfAnIdleServerIsQuick) {
  TestServer server([](ServerOptions& options) { options.metrics_listen = ""; });
  const auto start = std::chrono::steady_clock::now();
  server.server().Drain(absl::Minutes(10));
  server.server().Drain(absl::Minutes(10));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

TEST(LifecycleTest, DestructionEndsOpenCalls) {
  auto server = std::make_unique<TestServer>();
  TestCall by_socket(server->NewChannel());
  const std::shared_ptr<grpc::Channel> in_process = server->server().InProcessChannel();
  TestCall without_socket(in_process);
  ASSERT_TRUE(by_socket.SendHeader({}) && without_socket.SendHeader({}));
  by_socket.ReadAccepted();
  without_socket.ReadAccepted();
  server.reset();
  EXPECT_FALSE(by_socket.Finish().status.ok());
  EXPECT_FALSE(without_socket.Finish().status.ok());
}

}  // namespace
}  // namespace curvd
