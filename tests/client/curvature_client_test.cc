#include "client/curvature_client.h"

#include <gmock/gmock.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client/surfaces/surface.h"
#include "curvature/v1/curvature.grpc.pb.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "server/curvature_server.h"

namespace curv {
namespace {

namespace v1 = curvature::v1;
using ::testing::HasSubstr;

struct SphereCloud {
  std::vector<float> points;  // of the unit sphere: their own normals
  CloudView view() const { return {points, points}; }
};

SphereCloud Sphere(size_t count) {
  SphereCloud cloud;
  const std::vector<Vec3> positions = *SampleEvenly(**MakeSurface("sphere"), count, 0);
  for (const Vec3& p : positions) {
    for (int axis = 0; axis < 3; ++axis) cloud.points.push_back(static_cast<float>(p[axis]));
  }
  return cloud;
}

std::unique_ptr<curvd::CurvatureServer> StartServer(const curvd::ServerOptions& changes = {}) {
  curvd::ServerOptions options = changes;
  options.listen = "127.0.0.1:0";
  options.metrics_listen = "";
  options.threads = 2;
  options.log = false;
  return *curvd::CurvatureServer::Create(options);
}

std::string AddressOf(int port) { return absl::StrCat("127.0.0.1:", port); }

TEST(CurvatureClientTest, NamesEveryEstimator) {
  const std::span<const std::string_view> names = EstimatorNames();
  for (size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(EstimatorName(static_cast<Estimator>(i)), names[i]);
    EXPECT_EQ(EstimatorOf(names[i]), static_cast<Estimator>(i));
  }
  EXPECT_EQ(EstimatorOf("best"), std::nullopt);
}

TEST(CurvatureClientTest, ServerKnowsEveryEstimator) {
  const auto server = StartServer();
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  const SphereCloud cloud = Sphere(500);
  for (const std::string_view name : EstimatorNames()) {
    EstimateOptions options;
    options.estimator = *EstimatorOf(name);
    const absl::StatusOr<CurvatureResult> result = client->Estimate(cloud.view(), options);
    ASSERT_TRUE(result.ok()) << name << ": " << result.status();
    EXPECT_EQ(result->summary.status_counts[1], 500u) << name;
  }
  const auto info = client->GetServerInfo(absl::Seconds(10));
  ASSERT_TRUE(info.ok()) << info.status();
  EXPECT_THAT(info->estimators, ::testing::ElementsAreArray(EstimatorNames().begin(), EstimatorNames().end()));
}

TEST(CurvatureClientTest, JetDegreeReachesTheServer) {
  const auto server = StartServer();
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  const SphereCloud cloud = Sphere(500);
  EstimateOptions options;
  options.estimator = Estimator::kJetFitting;
  options.neighbor_count = 14;  // one less than a polynomial of degree 4 has coefficients
  options.jet_degree = 4;
  const absl::StatusOr<CurvatureResult> result = client->Estimate(cloud.view(), options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->summary.status_counts[static_cast<size_t>(PointStatus::kSingularFit)], 500u);
}

TEST(CurvatureClientTest, EstimatesASphere) {
  const auto server = StartServer();
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  const SphereCloud cloud = Sphere(5000);
  const absl::StatusOr<CurvatureResult> result = client->Estimate(cloud.view(), {});
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_EQ(result->mean.size(), 5000u);
  EXPECT_EQ(result->summary.status_counts[1], 5000u);
  // Neighborhoods of 50 of 5000 points have a radius of 0.2: the mean over them differs from 1 by a share of its
  // square.
  for (const float mean : result->mean) EXPECT_NEAR(mean, 1.0f, 0.03f);
}

TEST(CurvatureClientTest, DoublesFloatsChannelsAndChunksAgree) {
  const auto server = StartServer();
  const SphereCloud cloud = Sphere(2000);
  const std::vector<double> doubles(cloud.points.begin(), cloud.points.end());
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  const CurvatureClient in_process(server->InProcessChannel());
  const CurvatureResult expected = *client->Estimate(cloud.view(), {});
  EXPECT_EQ(in_process.Estimate(cloud.view(), {})->d1, expected.d1);
  EstimateOptions small_chunks;
  small_chunks.chunk_bytes = 1;
  EXPECT_EQ(client->Estimate(cloud.view(), small_chunks)->mean, expected.mean);
  const CurvatureResult exact = *client->Estimate(CloudView(doubles, doubles), {});
  // The same numbers, but relative to another origin: they are rounded to float anew.
  for (size_t i = 0; i < exact.mean.size(); ++i) EXPECT_NEAR(exact.mean[i], expected.mean[i], 1e-3f);
}

TEST(CurvatureClientTest, KeepsToTheServersChunkLimit) {
  curvd::ServerOptions options;
  options.max_chunk_bytes = 1024;
  const auto server = StartServer(options);
  const auto client = *CurvatureClient::Connect(AddressOf(server->port()));
  EXPECT_TRUE(client->Estimate(Sphere(1000).view(), {}).ok());
}

TEST(CurvatureClientTest, EmptyCloudsHaveEmptyResults) {
  const auto server = StartServer();
  const CurvatureClient client(server->InProcessChannel());
  const absl::StatusOr<CurvatureResult> result = client.Estimate(Sphere(1).view(), {});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->status[0], static_cast<uint8_t>(PointStatus::kTooFewNeighbors));
  const absl::StatusOr<CurvatureResult> none = client.Estimate(CloudView(std::span<const float>(), {}), {});
  ASSERT_TRUE(none.ok()) << none.status();
  EXPECT_TRUE(none->mean.empty());
}

TEST(CurvatureClientTest, RefusesArraysThatDoNotMatch) {
  const auto server = StartServer();
  const CurvatureClient client(server->InProcessChannel());
  const std::vector<float> four(4), three(3), six(6);
  EXPECT_THAT(client.Estimate(CloudView(four, four), {}).status().message(), HasSubstr("positions hold 4 scalars"));
  EXPECT_THAT(client.Estimate(CloudView(six, three), {}).status().message(), HasSubstr("normals 3"));
}

TEST(CurvatureClientTest, PassesTheServersErrorsOn) {
  const auto server = StartServer();
  const CurvatureClient client(server->InProcessChannel());
  SphereCloud cloud = Sphere(100);
  cloud.points[30] = NAN;
  const absl::Status status = client.Estimate(cloud.view(), {}).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_THAT(status.message(), HasSubstr("10"));
  EXPECT_NE(ErrorReason(status), "");
  EstimateOptions skip;
  skip.skip_invalid = true;
  const absl::StatusOr<CurvatureResult> result = client.Estimate(cloud.view(), skip);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->status[10], static_cast<uint8_t>(PointStatus::kInvalidInput));
}

TEST(CurvatureClientTest, ReportsProgressToTheEnd) {
  const auto server = StartServer();
  const CurvatureClient client(server->InProcessChannel());
  EstimateProgress last;
  const SphereCloud cloud = Sphere(50'000);
  EstimateCallbacks callbacks;
  callbacks.on_progress = [&](const EstimateProgress& progress) {
    EXPECT_GE(progress.points_sent, last.points_sent);
    EXPECT_GE(progress.phase, last.phase);
    last = progress;
  };
  ASSERT_TRUE(client.Estimate(cloud.view(), {}, callbacks).ok());
  EXPECT_EQ(last.points_sent, 50'000u);
  EXPECT_EQ(last.points_received, 50'000u);
}

TEST(CurvatureClientTest, StopsWhenAsked) {
  const auto server = StartServer();
  const CurvatureClient client(server->InProcessChannel());
  std::stop_source stop;
  EstimateCallbacks callbacks{.on_progress = [&](const EstimateProgress&) { stop.request_stop(); },
                              .stop = stop.get_token()};
  EXPECT_TRUE(absl::IsCancelled(client.Estimate(Sphere(20'000).view(), {}, callbacks).status()));
}

TEST(CurvatureClientTest, TellsAboutTheServer) {
  const auto server = StartServer();
  const absl::StatusOr<ServerInfo> info =
      (*CurvatureClient::Connect(AddressOf(server->port())))->GetServerInfo(absl::Seconds(10));
  ASSERT_TRUE(info.ok()) << info.status();
  EXPECT_EQ(info->health, "SERVING");
  EXPECT_EQ(info->worker_threads, 2u);
  EXPECT_THAT(info->estimators, ::testing::Contains("avg-hexagram"));
  EXPECT_GT(info->max_points, 0u);
}

TEST(CurvatureClientTest, RefusesBadServerLists) {
  for (const char* servers : {"", "localhost", "a:1,", "a:1,,b:2", ":50061", "host:"}) {
    EXPECT_THAT(CurvatureClient::Connect(servers).status().message(), HasSubstr("is not HOST:PORT")) << servers;
  }
}

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

TEST(CurvatureClientRetryTest, AnUnreachableServerIsUnavailable) {
  EstimateOptions options;
  options.max_attempts = 2;
  EXPECT_TRUE(absl::IsUnavailable((*CurvatureClient::Connect("127.0.0.1:1"))->Estimate(kEmpty, options).status()));
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

}  // namespace
}  // namespace curv
