// What becomes of a call when the n-th allocation for an answer finds no memory, for every n.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "server/call/estimate_call.h"
#include "server/call/result_encoder.h"
#include "server/rpc/error_reasons.h"
#include "tests/core/failing_new.h"
#include "tests/server/rpc/fake_transport.h"
#include "tests/server/rpc/test_service.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using testing::FailingNew;

constexpr uint64_t kPoints = 2 * kResultChunkPoints;

std::string Header() {
  v1::EstimateCurvatureRequest request;
  request.mutable_header()->set_point_count(kPoints);
  request.mutable_header()->mutable_options()->set_neighbor_count(10);
  return request.SerializeAsString();
}

// All points of a cloud, on the lines of a grid.
std::string Chunk() {
  std::string positions, normals;
  for (uint64_t i = 0; i < kPoints; ++i) {
    const float position[] = {static_cast<float>(i % 181), static_cast<float>(i / 181), 0.0f};
    const float normal[] = {0.0f, 0.0f, 1.0f};
    positions.append(reinterpret_cast<const char*>(position), sizeof(position));
    normals.append(reinterpret_cast<const char*>(normal), sizeof(normal));
  }
  v1::EstimateCurvatureRequest request;
  request.mutable_chunk()->set_positions(positions);
  request.mutable_chunk()->set_normals(normals);
  return request.SerializeAsString();
}

// Nothing of gRPC's stand-in fails: as soon as the call hands something over, the failure is switched off.
class SparedTransport final : public FakeTransport {
 public:
  void StartWrite(const grpc::ByteBuffer* message) override {
    if (failure != nullptr) failure->Stop();
    FakeTransport::StartWrite(message);
    ++writes;
  }
  void Finish(const grpc::Status& status) override {
    if (failure != nullptr) failure->Stop();
    FakeTransport::Finish(status);
    ++writes;
  }
  // Until so many messages were written, the status among them, some of them on the worker of the job.
  void WaitFor(int count) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (writes < count && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    ASSERT_GE(writes, count);
  }

  FailingNew* failure = nullptr;
  std::atomic<int> writes = 0;
};

// Makes a call of which an allocation fails, the one after `first` others, while answer number `answer` is made.
// Returns the status of the call if the allocation was that answer's.
std::optional<grpc::Status> FailAnswer(int answer, size_t first) {
  ServiceContext service(TestServiceOptions());
  SparedTransport transport;
  auto call = std::make_shared<EstimateCall>(service, ArrivalFrom("ipv4:10.0.0.7:1234"), transport);
  call->Start();
  transport.Deliver(*call, Header());
  transport.EndWrite(*call);
  transport.Deliver(*call, Chunk());
  transport.DeliverEnd(*call);
  transport.WaitFor(2);
  for (int i = 3; i < answer; ++i) transport.EndWrite(*call);
  bool has_failed = false;
  {
    FailingNew failure(first, FailingNew::Failing::kOne);
    transport.failure = &failure;
    transport.EndWrite(*call);
    has_failed = failure.has_failed();
    transport.failure = nullptr;
  }
  if (!has_failed) call->OnCancel();
  if (transport.is_writing) transport.EndWrite(*call, false);
  call->OnDone();
  return has_failed ? transport.finished : std::nullopt;
}

// Answers are made on gRPC's threads, where what is thrown ends the process.
TEST(OutOfMemoryTest, ACallWhoseAnswerFindsNoMemorySaysSo) {
  constexpr int kSecondResults = 3, kSummary = 4;
  size_t failed = 0;
  for (const int answer : {kSecondResults, kSummary}) {
    size_t first = 0;
    for (;; ++first) {
      const std::optional<grpc::Status> status = FailAnswer(answer, first);
      if (!status.has_value()) break;
      EXPECT_EQ(status->error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << first << " " << status->error_message();
    }
    failed += first;
  }
  // Results may take gRPC's own memory alone, which is not of operator new: so they do in the build with ASan.
  EXPECT_GT(failed, 0u) << "no answer allocates anything";
}

}  // namespace
}  // namespace curvd
