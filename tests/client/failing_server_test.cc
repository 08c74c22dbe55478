// The C++ client against servers that fail: what it tries again, and what it makes of answers that break the protocol.
#include <gmock/gmock.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client/curvature_client.h"
#include "curvature/v1/curvature.grpc.pb.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "tests/client/local_server.h"
#include "tests/client/sphere_cloud.h"

namespace curv {
namespace {

namespace v1 = curvature::v1;
using ::testing::HasSubstr;

// A server that fails on purpose.
class ScriptedService : public v1::CurvatureService::Service {
 public:
  using Stream = grpc::ServerReaderWriter<v1::EstimateCurvatureResponse, v1::EstimateCurvatureRequest>;
  // Answers call number `call` (from 1).
  using Script = std::function<grpc::Status(int call, Stream& stream, grpc::ServerContext& context)>;

  explicit ScriptedService(Script script) : script_(std::move(script)) {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
  }
  ~ScriptedService() override { server_->Shutdown(std::chrono::system_clock::now()); }

  grpc::Status EstimateCurvature(grpc::ServerContext* context, Stream* stream) override {
    return script_(++calls_, *stream, *context);
  }
  std::string address() const { return AddressOf(port_); }
  std::shared_ptr<grpc::Channel> InProcessChannel() { return server_->InProcessChannel(grpc::ChannelArguments()); }
  int calls() const { return calls_; }

 private:
  Script script_;
  int port_ = 0;
  std::atomic<int> calls_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

grpc::Status Unavailable() { return {grpc::StatusCode::UNAVAILABLE, "draining"}; }

void Accept(ScriptedService::Stream& stream) {
  v1::EstimateCurvatureResponse response;
  response.mutable_accepted()->mutable_limits()->set_max_chunk_bytes(1 << 20);
  stream.Write(response);
}

void ReadAll(ScriptedService::Stream& stream) {
  v1::EstimateCurvatureRequest request;
  while (stream.Read(&request)) {
  }
}

// What a server answers to an empty cloud.
grpc::Status Succeed(ScriptedService::Stream& stream) {
  Accept(stream);
  ReadAll(stream);
  v1::EstimateCurvatureResponse response;
  response.mutable_summary();
  stream.Write(response);
  return grpc::Status::OK;
}

const CloudView kEmpty(std::span<const float>(), {});

TEST(CurvatureClientRetryTest, TriesAgainWhileUnavailable) {
  ScriptedService service([](int call, ScriptedService::Stream& stream, grpc::ServerContext&) {
    return call < 3 ? Unavailable() : Succeed(stream);
  });
  const absl::StatusOr<CurvatureResult> result = (*CurvatureClient::Connect(service.address()))->Estimate(kEmpty, {});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->summary.attempts, 3);
}

// Such a channel has no connection, and gRPC ends a process that waits for one.
TEST(CurvatureClientRetryTest, TriesAgainInItsOwnProcess) {
  ScriptedService service([](int call, ScriptedService::Stream& stream, grpc::ServerContext&) {
    return call < 3 ? Unavailable() : Succeed(stream);
  });
  const absl::StatusOr<CurvatureResult> result = CurvatureClient(service.InProcessChannel()).Estimate(kEmpty, {});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->summary.attempts, 3);
}

TEST(CurvatureClientRetryTest, TriesAgainWhenAProxyLosesTheServer) {
  ScriptedService service([](int call, ScriptedService::Stream& stream, grpc::ServerContext&) {
    if (call == 1) return grpc::Status(grpc::StatusCode::UNKNOWN, "Stream removed");
    if (call == 2) return grpc::Status(grpc::StatusCode::INTERNAL, "Received RST_STREAM with error code 2");
    return Succeed(stream);
  });
  const absl::StatusOr<CurvatureResult> result = (*CurvatureClient::Connect(service.address()))->Estimate(kEmpty, {});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->summary.attempts, 3);
}

TEST(CurvatureClientRetryTest, DoesNotRepeatWhatBreaksTheServer) {
  ScriptedService service([](int, ScriptedService::Stream&, grpc::ServerContext&) {
    google::rpc::ErrorInfo info;
    info.set_reason("INTERNAL");
    google::rpc::Status details;
    details.add_details()->PackFrom(info);
    return grpc::Status(grpc::StatusCode::INTERNAL, "a defect", details.SerializeAsString());
  });
  EXPECT_TRUE(absl::IsInternal((*CurvatureClient::Connect(service.address()))->Estimate(kEmpty, {}).status()));
  EXPECT_EQ(service.calls(), 1);
}

TEST(CurvatureClientRetryTest, GivesUpAfterTheLastAttempt) {
  ScriptedService service([](int, ScriptedService::Stream&, grpc::ServerContext&) { return Unavailable(); });
  EstimateOptions options;
  options.max_attempts = 2;
  EXPECT_TRUE(absl::IsUnavailable((*CurvatureClient::Connect(service.address()))->Estimate(kEmpty, options).status()));
  EXPECT_EQ(service.calls(), 2);
}

TEST(CurvatureClientRetryTest, DoesNotRepeatWhatIsWrong) {
  ScriptedService service([](int, ScriptedService::Stream&, grpc::ServerContext&) {
    return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "K is 3");
  });
  EXPECT_TRUE(absl::IsInvalidArgument((*CurvatureClient::Connect(service.address()))->Estimate(kEmpty, {}).status()));
  EXPECT_EQ(service.calls(), 1);
}

TEST(CurvatureClientRetryTest, WaitsAsLongAsTheServerAsks) {
  ScriptedService service([](int call, ScriptedService::Stream& stream, grpc::ServerContext&) {
    if (call > 1) return Succeed(stream);
    google::rpc::RetryInfo wait;
    wait.mutable_retry_delay()->set_nanos(600'000'000);
    google::rpc::Status details;
    details.add_details()->PackFrom(wait);
    return grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "full", details.SerializeAsString());
  });
  const absl::Time start = absl::Now();
  EXPECT_TRUE((*CurvatureClient::Connect(service.address()))->Estimate(kEmpty, {}).ok());
  EXPECT_GE(absl::Now() - start, absl::Milliseconds(600));
}

TEST(CurvatureClientRetryTest, GoesOnToAnotherServer) {
  const auto server = StartServer();
  ScriptedService broken([](int, ScriptedService::Stream&, grpc::ServerContext&) { return Unavailable(); });
  const SphereCloud cloud = Sphere(1000);
  const auto client =
      *CurvatureClient::Connect(absl::StrCat("127.0.0.1:1,", broken.address(), ",", AddressOf(server->port())));
  for (int call = 0; call < 3; ++call) {
    const absl::StatusOr<CurvatureResult> result = client->Estimate(cloud.view(), {});
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_LE(result->summary.attempts, 3);
  }
}

// Each client begins with a server of its own choice.
TEST(CurvatureClientRetryTest, TriesEachServerHoweverLongTheFirstTook) {
  const auto server = StartServer();
  const SphereCloud cloud = Sphere(1000);
  EstimateOptions options;
  options.connect_timeout = absl::ZeroDuration();
  for (int i = 0; i < 20; ++i) {
    const auto client = *CurvatureClient::Connect(absl::StrCat("127.0.0.1:1,", AddressOf(server->port())));
    const absl::StatusOr<CurvatureResult> result = client->Estimate(cloud.view(), options);
    EXPECT_TRUE(result.ok()) << result.status();
  }
}

TEST(CurvatureClientRetryTest, EndsAtTheTimeout) {
  // Accepts, and then says nothing until the client is gone.
  ScriptedService service([](int, ScriptedService::Stream& stream, grpc::ServerContext& context) {
    Accept(stream);
    ReadAll(stream);
    while (!context.IsCancelled()) std::this_thread::yield();
    return grpc::Status::CANCELLED;
  });
  EstimateOptions options;
  options.timeout = absl::Milliseconds(200);
  EXPECT_TRUE(
      absl::IsDeadlineExceeded((*CurvatureClient::Connect(service.address()))->Estimate(kEmpty, options).status()));
}

// In Python gRPC's own retries left such calls open for good.
TEST(CurvatureClientRetryTest, CallsEndThoughTheServerWasDrainedSinceTheLast) {
  const SphereCloud cloud = Sphere(2'000);
  auto server = StartServer();
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  ASSERT_TRUE(client->Estimate(cloud.view(), {}).ok());
  server->Drain(absl::Seconds(1));
  server.reset();
  EstimateOptions options;
  options.timeout = absl::Seconds(1);
  const absl::Time start = absl::Now();
  const absl::Status status = client->Estimate(cloud.view(), options).status();
  EXPECT_TRUE(absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status)) << status;
  EXPECT_LT(absl::Now() - start, absl::Seconds(10));
}

TEST(CurvatureClientRetryTest, AnUnreachableServerIsUnavailable) {
  EstimateOptions options;
  options.max_attempts = 2;
  EXPECT_TRUE(absl::IsUnavailable((*CurvatureClient::Connect("127.0.0.1:1"))->Estimate(kEmpty, options).status()));
}

// Six attempts would take eight seconds.
TEST(CurvatureClientRetryTest, AServerThatNeverAnsweredIsGivenUpEarly) {
  const auto client = CurvatureClient::Connect("127.0.0.1:1");
  ASSERT_TRUE(client.ok()) << client.status();
  const absl::Time start = absl::Now();
  EXPECT_EQ((*client)->Estimate(kEmpty, {}).status().code(), absl::StatusCode::kUnavailable);
  EXPECT_LT(absl::Now() - start, absl::Seconds(4));
}

TEST(CurvatureClientProtocolTest, AnOkWithoutSummaryIsInternal) {
  ScriptedService service([](int, ScriptedService::Stream& stream, grpc::ServerContext&) {
    Accept(stream);
    ReadAll(stream);
    return grpc::Status::OK;
  });
  const absl::Status status = (*CurvatureClient::Connect(service.address()))->Estimate(Sphere(10).view(), {}).status();
  EXPECT_TRUE(absl::IsInternal(status)) << status;
  EXPECT_THAT(status.message(), HasSubstr("without a summary"));
}

TEST(CurvatureClientProtocolTest, AGapIsInternalAlsoWhileTheServerGoesOn) {
  ScriptedService service([](int, ScriptedService::Stream& stream, grpc::ServerContext& context) {
    Accept(stream);
    ReadAll(stream);
    v1::EstimateCurvatureResponse response;
    response.mutable_result()->set_first_index(5);
    response.mutable_result()->set_point_count(1);
    while (!context.IsCancelled() && stream.Write(response)) {
    }
    return grpc::Status::OK;
  });
  const absl::Status status = (*CurvatureClient::Connect(service.address()))->Estimate(Sphere(10).view(), {}).status();
  EXPECT_TRUE(absl::IsInternal(status)) << status;
  EXPECT_THAT(status.message(), HasSubstr("from index 5"));
}

TEST(CurvatureClientProtocolTest, AnEarlyRefusalStopsTheSending) {
  ScriptedService service([](int, ScriptedService::Stream& stream, grpc::ServerContext&) {
    Accept(stream);
    v1::EstimateCurvatureRequest request;
    stream.Read(&request);
    stream.Read(&request);
    return grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "enough");
  });
  const std::vector<float> zeros(30'000'000);
  const absl::Status status =
      (*CurvatureClient::Connect(service.address()))->Estimate(CloudView(zeros, zeros), {}).status();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
}

// Accepts a cloud, and reads none of it.
grpc::Status AcceptAndWait(ScriptedService::Stream& stream, grpc::ServerContext& context) {
  Accept(stream);
  while (!context.IsCancelled()) absl::SleepFor(absl::Milliseconds(5));
  return grpc::Status::CANCELLED;
}

TEST(CurvatureClientProtocolTest, StopsWhileTheServerTakesNothing) {
  ScriptedService service([](int, ScriptedService::Stream& stream, grpc::ServerContext& context) {
    return AcceptAndWait(stream, context);
  });
  const std::vector<float> zeros(30'000'000);
  std::stop_source stop;
  std::jthread stopper([&] {
    absl::SleepFor(absl::Milliseconds(300));
    stop.request_stop();
  });
  const absl::Status status = (*CurvatureClient::Connect(service.address()))
                                  ->Estimate(CloudView(zeros, zeros), {}, {.on_progress = {}, .stop = stop.get_token()})
                                  .status();
  EXPECT_TRUE(absl::IsCancelled(status)) << status;
}

TEST(CurvatureClientProtocolTest, AnExceptionOfTheCallbackEndsTheCall) {
  for (const uint64_t points_sent : {0, 1}) {  // before the call, and with chunks under way
    ScriptedService service([](int, ScriptedService::Stream& stream, grpc::ServerContext& context) {
      return AcceptAndWait(stream, context);
    });
    const std::vector<float> zeros(30'000'000);
    EstimateCallbacks callbacks;
    callbacks.on_progress = [points_sent](const EstimateProgress& progress) {
      if (progress.points_sent >= points_sent) throw std::runtime_error("enough");
    };
    const auto client = *CurvatureClient::Connect(service.address());
    EXPECT_THROW((void)client->Estimate(CloudView(zeros, zeros), {}, callbacks), std::runtime_error);
  }
}

}  // namespace
}  // namespace curv
