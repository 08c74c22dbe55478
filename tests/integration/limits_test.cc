// The limits that calls share: streams and memory.
#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

#include "server/rpc/error_reasons.h"
#include "tests/integration/clouds.h"
#include "tests/integration/test_call.h"
#include "tests/integration/test_server.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using grpc::StatusCode;

// With 64 MiB, a large call may take 56 MiB: half a million points; two of 300,000 do not fit at a time.
constexpr uint64_t kMemory = 64 << 20;
constexpr size_t kLargePoints = 300'000;

v1::CloudHeader CheapHeader(size_t points) {
  v1::CloudHeader header;
  header.set_point_count(points);
  header.mutable_options()->set_neighbor_count(4);
  return header;
}

TEST(LimitsTest, OneStreamTooManyIsToldToComeBack) {
  TestServer server([](ServerOptions& options) { options.max_streams = 2; });
  TestCall first(server.NewChannel()), second(server.NewChannel());
  ASSERT_TRUE(first.SendHeader({}) && second.SendHeader({}));
  first.ReadAccepted();
  second.ReadAccepted();
  TestCall third(server.NewChannel());
  third.SendHeader({});
  const CallResult refused = third.Finish();
  EXPECT_TRUE(
      FailedWith(refused, StatusCode::RESOURCE_EXHAUSTED, kReasonStreamLimit, {"open calls", "2", "max_streams"}));
  ASSERT_TRUE(refused.retry_seconds.has_value());
  EXPECT_GT(*refused.retry_seconds, 0.0);
  first.HalfClose();
  EXPECT_TRUE(Succeeded(first.Finish(), 0));
  server.WaitForMetric("curvd_streams_open", 1);
  const TestCloud cloud = Sphere(100, 1.0f);
  EXPECT_TRUE(Succeeded(Estimate(server.NewChannel(), HeaderFor(cloud), cloud), 100));
}

TEST(LimitsTest, TooManyPointsAreRefusedAtTheHeader) {
  TestServer server([](ServerOptions& options) { options.max_points = 1'000; });
  TestCall call(server.NewChannel());
  call.SendHeader(CheapHeader(1'001));
  EXPECT_TRUE(FailedWith(call.Finish(), StatusCode::RESOURCE_EXHAUSTED, kReasonTooManyPoints,
                         {"header.point_count", "1001", "1000", "max_points"}));
}

TEST(LimitsTest, ACloudThatNeverFitsIsRefusedForGood) {
  TestServer server([](ServerOptions& options) { options.memory_limit_bytes = kMemory; });
  TestCall call(server.NewChannel());
  call.SendHeader(CheapHeader(10'000'000));
  const CallResult result = call.Finish();
  EXPECT_TRUE(FailedWith(result, StatusCode::RESOURCE_EXHAUSTED, kReasonMemoryLimit,
                         {"header.point_count", "10000000", "memory_limit"}));
  EXPECT_FALSE(result.retry_seconds.has_value());
}

TEST(LimitsTest, ACloudWaitsForTheMemoryOfAnother) {
  TestServer server([](ServerOptions& options) { options.memory_limit_bytes = kMemory; });
  const TestCloud cloud = Sphere(kLargePoints, 1.0f);
  TestCall first(server.NewChannel());
  ASSERT_TRUE(first.SendHeader(CheapHeader(cloud.size())));
  first.ReadAccepted();
  server.WaitForMetric("curvd_queue_jobs{queue=\"memory\"}", 0);

  std::thread second(
      [&] { EXPECT_TRUE(Succeeded(Estimate(server.NewChannel(), CheapHeader(cloud.size()), cloud), cloud.size())); });
  server.WaitForMetric("curvd_queue_jobs{queue=\"memory\"}", 1);
  const TestCloud small = Sphere(1'000, 1.0f);
  EXPECT_TRUE(Succeeded(Estimate(server.NewChannel(), HeaderFor(small), small), small.size()))
      << "small clouds do not wait behind large ones";
  EXPECT_EQ(server.Metric("curvd_queue_jobs{queue=\"memory\"}"), 1.0);
  EXPECT_LE(server.Metric("curvd_memory_reserved_bytes"), static_cast<double>(kMemory));

  ASSERT_TRUE(first.SendCloud(cloud));
  first.HalfClose();
  EXPECT_TRUE(Succeeded(first.Finish(), cloud.size()));
  second.join();
  server.WaitUntilIdle();
}

TEST(LimitsTest, WaitingEndsWithTheCallersDeadline) {
  TestServer server([](ServerOptions& options) { options.memory_limit_bytes = kMemory; });
  TestCall first(server.NewChannel());
  ASSERT_TRUE(first.SendHeader(CheapHeader(kLargePoints)));
  first.ReadAccepted();
  TestCall second(server.NewChannel(), std::chrono::milliseconds(200));
  second.SendHeader(CheapHeader(kLargePoints));
  EXPECT_EQ(second.Finish().status.error_code(), StatusCode::DEADLINE_EXCEEDED);
  server.WaitForMetric("curvd_queue_jobs{queue=\"memory\"}", 0);
  server.WaitForMetric("curvd_streams_open", 1);
}

// The end of a call may come before, while or after it joins the queue.
TEST(LimitsTest, CallsThatEndAsTheyJoinTheQueueLeaveIt) {
  TestServer server([](ServerOptions& options) { options.memory_limit_bytes = kMemory; });
  TestCall first(server.NewChannel());
  ASSERT_TRUE(first.SendHeader(CheapHeader(kLargePoints)));
  first.ReadAccepted();
  const auto channel = server.NewChannel();
  for (int i = 0; i < 300; ++i) {
    TestCall hasty(channel);
    hasty.SendHeader(CheapHeader(kLargePoints));
    std::this_thread::sleep_for(std::chrono::microseconds(7 * i));
    hasty.Cancel();
    EXPECT_EQ(hasty.Finish().status.error_code(), StatusCode::CANCELLED);
  }
  server.WaitForMetric("curvd_queue_jobs{queue=\"memory\"}", 0);
  server.WaitForMetric("curvd_streams_open", 1);
}

TEST(LimitsTest, TheQueueIsBounded) {
  TestServer server([](ServerOptions& options) {
    options.memory_limit_bytes = kMemory;
    options.max_waiting = 1;
  });
  TestCall first(server.NewChannel()), second(server.NewChannel()), third(server.NewChannel());
  ASSERT_TRUE(first.SendHeader(CheapHeader(kLargePoints)));
  first.ReadAccepted();
  server.WaitForMetric("curvd_queue_jobs{queue=\"memory\"}", 0);
  ASSERT_TRUE(second.SendHeader(CheapHeader(kLargePoints)));
  server.WaitForMetric("curvd_queue_jobs{queue=\"memory\"}", 1);
  third.SendHeader(CheapHeader(kLargePoints));
  const CallResult refused = third.Finish();
  EXPECT_TRUE(FailedWith(refused, StatusCode::RESOURCE_EXHAUSTED, kReasonQueueFull, {"wait", "1", "max_waiting"}));
  EXPECT_TRUE(refused.retry_seconds.has_value());
  // One waited until it gave up; the other was refused before it waited.
  second.Cancel();
  EXPECT_EQ(second.Finish().status.error_code(), StatusCode::CANCELLED);
  server.WaitForMetric("curvd_streams_open", 1);
  server.WaitForMetric("curvd_phase_seconds_count{phase=\"admit\"}", 1);
  EXPECT_GT(server.Metric("curvd_phase_seconds_sum{phase=\"admit\"}"), 0.0) << server.Scrape();
}

TEST(LimitsTest, CloudsOfUnknownSizeNeverTakeMoreThanTheLimit) {
  TestServer server([](ServerOptions& options) { options.memory_limit_bytes = kMemory; });
  const TestCloud cloud = Sphere(kLargePoints, 1.0f);
  v1::CloudHeader header = CheapHeader(0);
  std::vector<CallResult> results(4);
  std::vector<std::thread> clients;
  clients.reserve(results.size());
  for (CallResult& result : results) {
    clients.emplace_back([&, &result = result] { result = Estimate(server.NewChannel(), header, cloud, 20'000); });
  }
  for (std::thread& client : clients) client.join();
  int succeeded = 0;
  for (const CallResult& result : results) {
    if (result.status.ok()) {
      EXPECT_TRUE(Succeeded(result, cloud.size()));
      ++succeeded;
    } else {
      EXPECT_TRUE(FailedWith(result, StatusCode::RESOURCE_EXHAUSTED, kReasonMemoryBusy, {"memory_limit"}));
      EXPECT_TRUE(result.retry_seconds.has_value());
    }
  }
  EXPECT_GE(succeeded, 1) << "somebody always gets through";
  server.WaitUntilIdle();
}

TEST(LimitsTest, ACloudOfUnknownSizeThatOutgrowsTheServerIsRefused) {
  TestServer server([](ServerOptions& options) { options.memory_limit_bytes = kMemory; });
  const TestCloud cloud = Sphere(700'000, 1.0f);
  const CallResult result = Estimate(server.NewChannel(), CheapHeader(0), cloud);
  EXPECT_TRUE(
      FailedWith(result, StatusCode::RESOURCE_EXHAUSTED, kReasonMemoryLimit, {"memory of this call", "memory_limit"}));
  EXPECT_FALSE(result.retry_seconds.has_value());
}

}  // namespace
}  // namespace curvd
