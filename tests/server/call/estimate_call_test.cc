// A whole call without a socket: requests in, responses out, with a real worker and a real budget.
#include "server/call/estimate_call.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/call/result_encoder.h"
#include "server/rpc/error_reasons.h"
#include "tests/server/rpc/fake_transport.h"
#include "tests/server/rpc/test_service.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

std::string Header(uint64_t point_count) {
  v1::EstimateCurvatureRequest request;
  request.mutable_header()->set_point_count(point_count);
  return request.SerializeAsString();
}

// `count` points of a unit sphere, along a spiral of `total`.
std::string Chunk(uint64_t first, uint64_t count, uint64_t total) {
  std::string packed;
  for (uint64_t i = first; i < first + count; ++i) {
    const double height = 1 - (2 * i + 1) / static_cast<double>(total), angle = 2.39996 * i;
    const double ring = std::sqrt(1 - height * height);
    const float point[] = {static_cast<float>(ring * std::cos(angle)), static_cast<float>(ring * std::sin(angle)),
                           static_cast<float>(height)};
    packed.append(reinterpret_cast<const char*>(point), sizeof(point));
  }
  v1::EstimateCurvatureRequest request;
  request.mutable_chunk()->set_first_index(first);
  request.mutable_chunk()->set_positions(packed);
  request.mutable_chunk()->set_normals(packed);
  return request.SerializeAsString();
}

// The job writes on its worker; the test waits for it.
class WaitableTransport final : public FakeTransport {
 public:
  void StartWrite(const grpc::ByteBuffer* message) override {
    const std::lock_guard lock(mutex_);
    FakeTransport::StartWrite(message);
    changed_.notify_all();
  }
  void Finish(const grpc::Status& status) override {
    const std::lock_guard lock(mutex_);
    FakeTransport::Finish(status);
    changed_.notify_all();
  }
  // Until there is a write to end, or the call has finished.
  void WaitForGrpc() {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(changed_.wait_for(lock, std::chrono::minutes(1), [this] { return is_writing || finished; }));
  }
  v1::EstimateCurvatureResponse Last() {
    const std::lock_guard lock(mutex_);
    v1::EstimateCurvatureResponse response;
    EXPECT_TRUE(response.ParseFromString(written.back()));
    return response;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
};

class EstimateCallTest : public ::testing::Test {
 protected:
  void Start() {
    call_ = std::make_shared<EstimateCall>(service_, ArrivalFrom("ipv4:10.0.0.7:1234"), transport_);
    call_->Start();
  }
  // The next response that the call writes.
  v1::EstimateCurvatureResponse Next() {
    transport_.WaitForGrpc();
    const v1::EstimateCurvatureResponse response = transport_.Last();
    transport_.EndWrite(*call_);
    return response;
  }

  // gRPC is done with the call, and nobody else keeps it: waits until its memory is given back. Its job may hold it
  // until its last block is over.
  void Close() {
    call_->OnDone();
    call_.reset();
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (service_.admission.reserved() > 0 && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    EXPECT_EQ(service_.admission.reserved(), 0u);
  }

  ServiceContext service_{TestServiceOptions()};
  WaitableTransport transport_;
  std::shared_ptr<EstimateCall> call_;
};

TEST_F(EstimateCallTest, AnswersACloudInTheOrderOfTheProtocol) {
  const uint64_t points = kResultChunkPoints + 100;
  Start();
  transport_.Deliver(*call_, Header(points));
  EXPECT_TRUE(Next().has_accepted());
  transport_.Deliver(*call_, Chunk(0, points, points));
  transport_.DeliverEnd(*call_);
  const v1::EstimateCurvatureResponse first = Next();
  EXPECT_EQ(first.result().first_index(), 0u);
  EXPECT_EQ(first.result().point_count(), kResultChunkPoints);
  EXPECT_EQ(Next().result().point_count(), 100u);
  const v1::Summary summary = Next().summary();
  EXPECT_EQ(summary.point_count(), points);
  EXPECT_EQ(summary.status_counts().ok(), points);
  EXPECT_GT(summary.peak_bytes(), 0u);
  transport_.WaitForGrpc();
  EXPECT_TRUE(transport_.finished->ok()) << transport_.finished->error_message();
  Close();
  EXPECT_EQ(MetricOf(service_.metrics, "curvd_points_total{status=\"ok\"}"), static_cast<double>(points));
  EXPECT_EQ(MetricOf(service_.metrics, "curvd_phase_seconds_count{phase=\"send\"}"), 1);
}

// The results of a reader that takes nothing stay what they are: no second message is packed.
TEST_F(EstimateCallTest, PacksNoResultsAheadOfTheReader) {
  const uint64_t points = 2 * kResultChunkPoints;
  Start();
  transport_.Deliver(*call_, Header(points));
  Next();
  transport_.Deliver(*call_, Chunk(0, points, points));
  transport_.DeliverEnd(*call_);
  transport_.WaitForGrpc();
  const size_t written = transport_.written.size();
  for (int i = 0; i < 3; ++i) call_->Tick(BidiStream::Clock::now());
  EXPECT_EQ(transport_.written.size(), written);
  call_->OnCancel();
  transport_.EndWrite(*call_, false);
  call_->OnDone();
}

TEST_F(EstimateCallTest, ShowsProgressOnceAcceptedIsOnItsWay) {
  Start();
  call_->Tick(BidiStream::Clock::now());
  EXPECT_TRUE(transport_.written.empty());
  transport_.Deliver(*call_, Header(100));
  EXPECT_TRUE(Next().has_accepted());
  call_->Tick(BidiStream::Clock::now());
  const v1::Progress progress = Next().progress();
  EXPECT_EQ(progress.phase(), v1::Progress::PHASE_RECEIVING);
  EXPECT_FALSE(transport_.is_writing);
  call_->OnCancel();
  call_->OnDone();
}

// They fill the window of a peer that sends its whole cloud before it reads.
TEST_F(EstimateCallTest, ShowsNoProgressWhereThereIsNone) {
  ServerOptions options = TestServiceOptions();
  options.stall_timeout = absl::Minutes(5);
  ServiceContext service(options);
  call_ = std::make_shared<EstimateCall>(service, ArrivalFrom("ipv4:10.0.0.7:1234"), transport_);
  call_->Start();
  transport_.Deliver(*call_, Header(100));
  EXPECT_TRUE(Next().has_accepted());
  call_->Tick(BidiStream::Clock::now());
  EXPECT_TRUE(Next().has_progress());
  for (int i = 0; i < 3; ++i) call_->Tick(BidiStream::Clock::now());
  EXPECT_FALSE(transport_.is_writing);
  transport_.Deliver(*call_, Chunk(0, 50, 100));
  call_->Tick(BidiStream::Clock::now());
  EXPECT_EQ(Next().progress().points_received(), 50u);
  call_->Tick(BidiStream::Clock::now() + std::chrono::seconds(31));
  EXPECT_TRUE(Next().has_progress()) << "proxies end calls on which nothing moves";
  call_->OnCancel();
  call_->OnDone();
  call_.reset();
}

// A call that waits for memory is not read, so that its peer must stop; it goes on when another gives memory back.
TEST_F(EstimateCallTest, DoesNotReadWhileItWaitsForMemory) {
  const uint64_t most = 2'000'000;  // of 256 MiB
  Start();
  transport_.Deliver(*call_, Header(most));
  EXPECT_EQ(transport_.reads, 2);
  WaitableTransport second;
  const auto waiting = std::make_shared<EstimateCall>(service_, ArrivalFrom("ipv4:10.0.0.8:1"), second);
  waiting->Start();
  second.Deliver(*waiting, Header(most));
  EXPECT_EQ(second.reads, 1);
  EXPECT_EQ(service_.admission.waiting(), 1u);
  transport_.EndWrite(*call_);
  call_->OnCancel();
  call_->OnDone();
  call_.reset();
  EXPECT_EQ(second.reads, 2);
  second.EndWrite(*waiting);
  waiting->OnCancel();
  waiting->OnDone();
}

// A header reserves memory for all its points. Where they do not come, others get it; when they do, the call goes on.
TEST_F(EstimateCallTest, LendsItsMemoryToACallThatWaitsWhileItsPointsDoNotCome) {
  const uint64_t most = 2'000'000;
  Start();
  transport_.Deliver(*call_, Header(most));
  transport_.Deliver(*call_, Chunk(0, 1'000, most));
  WaitableTransport second;
  const auto waiting = std::make_shared<EstimateCall>(service_, ArrivalFrom("ipv4:10.0.0.8:1"), second);
  waiting->Start();
  second.Deliver(*waiting, Header(most));
  call_->Tick(BidiStream::Clock::now() + std::chrono::seconds(1));
  EXPECT_EQ(second.reads, 1) << "it may have been about to send more";
  call_->Tick(BidiStream::Clock::now() + std::chrono::seconds(3));
  EXPECT_EQ(second.reads, 2);
  const int reads = transport_.reads;
  transport_.Deliver(*call_, Chunk(1'000, 1'000, most));
  EXPECT_EQ(transport_.reads, reads + 1) << "there is room for what it sends now";
  second.EndWrite(*waiting);
  waiting->OnCancel();
  waiting->OnDone();
  transport_.EndWrite(*call_);
  call_->OnCancel();
  call_->OnDone();
}

TEST_F(EstimateCallTest, ACallWhosePointsComeInTimeKeepsItsMemory) {
  const uint64_t most = 2'000'000;
  Start();
  transport_.Deliver(*call_, Header(most));
  // Beyond a third of the cloud within 5 s: the rest comes within 10.
  for (uint64_t first = 0; first < 700'000; first += 100'000) transport_.Deliver(*call_, Chunk(first, 100'000, most));
  WaitableTransport second;
  const auto waiting = std::make_shared<EstimateCall>(service_, ArrivalFrom("ipv4:10.0.0.8:1"), second);
  waiting->Start();
  second.Deliver(*waiting, Header(most));
  call_->Tick(BidiStream::Clock::now() + std::chrono::seconds(4));
  EXPECT_EQ(second.reads, 1);
  second.EndWrite(*waiting);
  waiting->OnCancel();
  waiting->OnDone();
  transport_.EndWrite(*call_);
  call_->OnCancel();
  call_->OnDone();
}

TEST_F(EstimateCallTest, ChunksWithoutPointsDoNotKeepACallAlive) {
  Start();
  transport_.Deliver(*call_, Header(100));
  for (int i = 0; i < 1'100; ++i) transport_.Deliver(*call_, Chunk(0, 0, 100));
  // Each counts as 10 ms of waiting, of the 10 s that the server is patient.
  call_->Tick(BidiStream::Clock::now());
  EXPECT_FALSE(transport_.finished.has_value()) << "Accepted is on its way";
  transport_.EndWrite(*call_);
  ASSERT_TRUE(transport_.finished.has_value());
  EXPECT_EQ(transport_.finished->error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  call_->OnDone();
  EXPECT_EQ(MetricOf(service_.metrics, "curvd_failures_total{reason=\"STALLED\"}"), 1);
}

TEST_F(EstimateCallTest, ACallThatEndsWhileItWaitsLeavesTheQueue) {
  Start();
  transport_.Deliver(*call_, Header(2'000'000));
  WaitableTransport second;
  const auto waiting = std::make_shared<EstimateCall>(service_, ArrivalFrom("ipv4:10.0.0.8:1"), second);
  waiting->Start();
  second.Deliver(*waiting, Header(2'000'000));
  waiting->OnCancel();
  EXPECT_EQ(service_.admission.waiting(), 0u);
  second.EndWrite(*waiting);
  waiting->OnDone();
  EXPECT_EQ(MetricOf(service_.metrics, "curvd_phase_seconds_count{phase=\"admit\"}"), 1);
  transport_.EndWrite(*call_);
  call_->OnCancel();
  call_->OnDone();
}

TEST_F(EstimateCallTest, ABadMessageEndsTheCallWithItsReason) {
  Start();
  transport_.Deliver(*call_, "\xff\xff no message");
  EXPECT_EQ(transport_.finished->error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  call_->OnDone();
  EXPECT_EQ(MetricOf(service_.metrics, "curvd_failures_total{reason=\"MESSAGE_MALFORMED\"}"), 1);
}

TEST_F(EstimateCallTest, AJobThatFailsEndsTheCallAndCountsItsPhases) {
  const uint64_t points = 20'000;
  v1::EstimateCurvatureRequest header;
  header.mutable_header()->set_point_count(points);
  header.mutable_header()->mutable_options()->set_radius(100.0);
  Start();
  transport_.Deliver(*call_, header.SerializeAsString());
  Next();
  transport_.Deliver(*call_, Chunk(0, points, points));
  transport_.DeliverEnd(*call_);
  transport_.WaitForGrpc();
  ASSERT_TRUE(transport_.finished.has_value());
  EXPECT_EQ(transport_.finished->error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  call_->OnDone();
  EXPECT_EQ(MetricOf(service_.metrics, "curvd_failures_total{reason=\"NEIGHBORHOOD_TOO_LARGE\"}"), 1);
  EXPECT_EQ(MetricOf(service_.metrics, "curvd_phase_seconds_count{phase=\"index\"}"), 1);
}

// Such a job is often over before the call has its handle.
TEST(SmallCallTest, JobsThatFailAtOnceCountTheirPhasesAllTheSame) {
  ServerOptions options = TestServiceOptions();
  options.max_neighbor_count = 10;
  ServiceContext service(options);
  v1::EstimateCurvatureRequest header;
  header.mutable_header()->mutable_options()->set_radius(100.0);
  const int calls = 1'000;
  for (int i = 0; i < calls; ++i) {
    WaitableTransport transport;
    const auto call = std::make_shared<EstimateCall>(service, ArrivalFrom("ipv4:10.0.0.7:1234"), transport);
    call->Start();
    transport.Deliver(*call, header.SerializeAsString());
    transport.WaitForGrpc();
    transport.EndWrite(*call);
    transport.Deliver(*call, Chunk(0, 20, 20));
    transport.DeliverEnd(*call);
    transport.WaitForGrpc();
    ASSERT_TRUE(transport.finished.has_value());
    call->OnDone();
  }
  EXPECT_EQ(MetricOf(service.metrics, "curvd_failures_total{reason=\"NEIGHBORHOOD_TOO_LARGE\"}"), calls);
  EXPECT_EQ(MetricOf(service.metrics, "curvd_phase_seconds_count{phase=\"index\"}"), calls);
}

TEST_F(EstimateCallTest, ACancelWhileItEstimatesEndsTheJobAndFreesItsMemory) {
  const uint64_t points = 50'000;
  v1::EstimateCurvatureRequest header;
  header.mutable_header()->set_point_count(points);
  header.mutable_header()->mutable_options()->set_neighbor_count(5'000);
  header.mutable_header()->mutable_options()->set_estimator(v1::ESTIMATOR_UNIFORM);
  header.mutable_header()->mutable_options()->set_triangle_count(10'000);
  Start();
  transport_.Deliver(*call_, header.SerializeAsString());
  Next();
  transport_.Deliver(*call_, Chunk(0, points, points));
  transport_.DeliverEnd(*call_);
  call_->OnCancel();
  EXPECT_EQ(transport_.finished->error_code(), grpc::StatusCode::CANCELLED);
  Close();
}

}  // namespace
}  // namespace curvd
