// Estimators and scales that the server chooses, through a real socket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "tests/integration/clouds.h"
#include "tests/integration/test_call.h"
#include "tests/integration/test_server.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

class ScaleTest : public ::testing::Test {
 protected:
  CallResult Run(const v1::CloudHeader& header, const TestCloud& cloud) { return Estimate(channel_, header, cloud); }

  TestServer server_;
  std::shared_ptr<grpc::Channel> channel_ = server_.NewChannel();
};

// Radius 1.
TestCloud NoisySphere(size_t points, float sigma) {
  TestCloud cloud = Sphere(points, 1.0f);
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0.0f, sigma);
  for (float& scalar : cloud.positions) scalar += noise(random);
  return cloud;
}

v1::CloudHeader AutomaticHeader(const TestCloud& cloud) {
  v1::CloudHeader header = HeaderFor(cloud);
  header.mutable_options()->set_estimator(v1::ESTIMATOR_AUTO);
  return header;
}

double MeanError(const CallResult& result, double truth) {
  double sum = 0.0;
  for (size_t i = 0; i < result.size(); ++i) sum += std::abs(result.Mean(i) - truth);
  return sum / static_cast<double>(result.size());
}

TEST_F(ScaleTest, ComesNearerToANoisySphereThanFiftyNeighbors) {
  const TestCloud cloud = NoisySphere(10'000, 0.01f);
  const CallResult chosen = Run(AutomaticHeader(cloud), cloud), fixed = Run(HeaderFor(cloud, 50), cloud);
  ASSERT_TRUE(Succeeded(chosen, 10'000));
  ASSERT_TRUE(Succeeded(fixed, 10'000));
  EXPECT_LT(MeanError(chosen, 1.0), 0.5 * MeanError(fixed, 1.0));
  EXPECT_FALSE(fixed.summary->has_scale());
}

TEST_F(ScaleTest, TheSummaryTellsWhatWasChosen) {
  const TestCloud cloud = NoisySphere(5'000, 0.01f);
  v1::CloudHeader header = AutomaticHeader(cloud);
  header.mutable_options()->mutable_automatic_scale()->set_least_neighbor_count(32);
  header.mutable_options()->mutable_automatic_scale()->set_most_neighbor_count(256);
  const CallResult result = Run(header, cloud);
  ASSERT_TRUE(Succeeded(result, 5'000));
  ASSERT_TRUE(result.summary->has_scale());
  const v1::ScaleReport& report = result.summary->scale();
  double shares = 0.0;
  for (const v1::ScaleOutcome& outcome : report.outcomes()) {
    EXPECT_TRUE(v1::Estimator_IsValid(outcome.estimator()) && outcome.estimator() != v1::ESTIMATOR_AUTO);
    EXPECT_TRUE(outcome.neighbor_count() >= 32 && outcome.neighbor_count() <= 256) << outcome.neighbor_count();
    EXPECT_TRUE(std::isfinite(outcome.error()) && outcome.error() > 0.0);
    EXPECT_TRUE(outcome.noise() >= 0.0 && outcome.bias() >= 0.0 && outcome.share() >= 0.0);
    shares += outcome.share();
  }
  EXPECT_NEAR(shares, 1.0, 1e-9);
  EXPECT_NEAR(report.position_noise(), 0.01, 0.002);
  EXPECT_GT(report.sampled_point_count(), 0u);
}

TEST_F(ScaleTest, CloudsThatAreTooSmallEndInStatuses) {
  for (const size_t points : {1, 8, 15}) {
    const TestCloud cloud = Sphere(points, 1.0f);
    const CallResult result = Run(AutomaticHeader(cloud), cloud);
    ASSERT_TRUE(Succeeded(result, points));
    EXPECT_EQ(result.summary->status_counts().too_few_neighbors(), points);
    EXPECT_TRUE(std::isnan(result.Mean(0)));
    EXPECT_EQ(result.summary->scale().outcomes_size(), 0);
  }
}

int StatusOf(const CallResult& result, size_t i) { return static_cast<unsigned char>(result.point_status[i]); }

// Whether every point with a number has finite ones, every other has a reason, and the summary counts them.
::testing::AssertionResult HasNumbersOrReasons(const CallResult& result) {
  uint64_t ok = 0;
  for (size_t i = 0; i < result.size(); ++i) {
    const bool is_ok = StatusOf(result, i) == v1::POINT_STATUS_OK;
    ok += is_ok ? 1 : 0;
    const float sum = result.Mean(i) + result.K1(i) + result.K2(i);
    if (is_ok != std::isfinite(sum)) {
      return ::testing::AssertionFailure() << "point " << i << ": status " << StatusOf(result, i) << ", sum " << sum;
    }
  }
  if (ok == result.summary->status_counts().ok()) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << ok << " points are ok, told are " << result.summary->status_counts().ok();
}

TEST_F(ScaleTest, APlaneWithExactZerosIsFlat) {
  TestCloud plane;
  for (size_t i = 0; i < 10'000; ++i) {
    plane.Add(static_cast<float>(i % 100), static_cast<float>(i / 100), 0.0f, 0.0f, 0.0f, 1.0f);
  }
  const CallResult result = Run(AutomaticHeader(plane), plane);
  ASSERT_TRUE(Succeeded(result, 10'000));
  EXPECT_TRUE(HasNumbersOrReasons(result));
  EXPECT_EQ(result.summary->status_counts().ok(), 10'000u);
  // The spacing is 1.
  for (size_t i = 0; i < result.size(); ++i) ASSERT_LT(std::abs(result.K1(i)) + std::abs(result.K2(i)), 1e-6) << i;
  for (const v1::ScaleOutcome& outcome : result.summary->scale().outcomes()) {
    EXPECT_TRUE(std::isfinite(outcome.error()) && std::isfinite(outcome.share())) << outcome.neighbor_count();
  }
}

TEST_F(ScaleTest, AnOutlierFarAwayHasAReasonAndSpoilsNothing) {
  TestCloud cloud = NoisySphere(5'000, 0.01f);
  cloud.Add(1e30f, 1e30f, 1e30f, 0.0f, 0.0f, 1.0f);
  const CallResult result = Run(AutomaticHeader(cloud), cloud),
                   alone = Run(AutomaticHeader(NoisySphere(5'000, 0.01f)), NoisySphere(5'000, 0.01f));
  ASSERT_TRUE(Succeeded(result, 5'001));
  ASSERT_TRUE(Succeeded(alone, 5'000));
  EXPECT_TRUE(HasNumbersOrReasons(result));
  EXPECT_GE(result.summary->status_counts().ok(), 5'000u);
  double sum = 0.0;
  for (size_t i = 0; i < 5'000; ++i) sum += std::abs(result.Mean(i) - 1.0);
  EXPECT_LT(sum / 5'000, 1.2 * MeanError(alone, 1.0));
}

// The points of a cloud on one side of z = 0.
void AddHalf(const TestCloud& from, bool upper, TestCloud& to) {
  for (size_t i = 0; i < from.size(); ++i) {
    const float *p = &from.positions[3 * i], *n = &from.normals[3 * i];
    if ((p[2] > 0.0f) == upper) to.Add(p[0], p[1], p[2], n[0], n[1], n[2]);
  }
}

// Ten times as many points on one half as on the other: each half gets nearly what it gets alone, although most of the
// sampled points lie in the dense one.
TEST_F(ScaleTest, TwoDensitiesEachGetScalesOfTheirOwn) {
  const TestCloud dense = NoisySphere(40'000, 0.01f), sparse = NoisySphere(4'000, 0.01f);
  TestCloud both;
  AddHalf(dense, true, both);
  const size_t dense_points = both.size();
  AddHalf(sparse, false, both);
  const CallResult result = Run(AutomaticHeader(both), both);
  ASSERT_TRUE(Succeeded(result, both.size()));
  EXPECT_TRUE(HasNumbersOrReasons(result));
  EXPECT_EQ(result.summary->status_counts().ok(), both.size());
  const auto error = [](const CallResult& of, const TestCloud& cloud, size_t first, size_t last) {
    double sum = 0.0;
    size_t count = 0;
    for (size_t i = first; i < last; ++i) {
      if (std::abs(cloud.positions[3 * i + 2]) < 0.4f) continue;  // neighborhoods there have both
      sum += std::abs(of.Mean(i) - 1.0);
      ++count;
    }
    return sum / static_cast<double>(count);
  };
  const auto error_alone = [&](const TestCloud& from, bool upper) {
    TestCloud half;
    AddHalf(from, upper, half);
    const CallResult alone = Run(AutomaticHeader(half), half);
    EXPECT_TRUE(Succeeded(alone, half.size()));
    return error(alone, half, 0, half.size());
  };
  EXPECT_LT(error(result, both, 0, dense_points), 1.2 * error_alone(dense, true));
  EXPECT_LT(error(result, both, dense_points, both.size()), 1.2 * error_alone(sparse, false));
}

TEST_F(ScaleTest, ChunksDoNotChangeAByte) {
  const TestCloud cloud = NoisySphere(5'000, 0.01f);
  const CallResult large = Estimate(channel_, AutomaticHeader(cloud), cloud);
  const CallResult small = Estimate(channel_, AutomaticHeader(cloud), cloud, 97);
  ASSERT_TRUE(Succeeded(large, 5'000));
  ASSERT_TRUE(Succeeded(small, 5'000));
  EXPECT_TRUE(large.AllBytes() == small.AllBytes());
  EXPECT_EQ(large.summary->scale().SerializeAsString(), small.summary->scale().SerializeAsString());
}

TEST_F(ScaleTest, ThreadsDoNotChangeAByte) {
  TestServer single([](ServerOptions& options) { options.threads = 1; });
  const TestCloud cloud = NoisySphere(5'000, 0.01f);
  const CallResult here = Run(AutomaticHeader(cloud), cloud);
  const CallResult there = Estimate(single.NewChannel(), AutomaticHeader(cloud), cloud);
  ASSERT_TRUE(Succeeded(here, 5'000));
  EXPECT_TRUE(here.AllBytes() == there.AllBytes());
}

TEST_F(ScaleTest, MemoryIsBackWhenTheCallIsOver) {
  const TestCloud cloud = NoisySphere(20'000, 0.01f);
  TestCall call(channel_);
  ASSERT_TRUE(call.SendHeader(AutomaticHeader(cloud)));
  ASSERT_TRUE(call.SendCloud(cloud, 5'000));
  call.HalfClose();
  while (const auto message = call.ReadAny()) {
    if (message->has_progress() && message->progress().phase() == v1::Progress::PHASE_ESTIMATING) break;
  }
  call.Cancel();
  call.Finish();
  server_.WaitUntilIdle();
}

TEST_F(ScaleTest, AServerOffersItWithinItsLimit) {
  TestServer small([](ServerOptions& options) { options.max_neighbor_count = 100; });
  const auto stub = v1::CurvatureService::NewStub(small.NewChannel());
  grpc::ClientContext context;
  v1::GetServerInfoResponse info;
  ASSERT_TRUE(stub->GetServerInfo(&context, {}, &info).ok());
  EXPECT_THAT(info.estimators(), ::testing::Contains(v1::ESTIMATOR_AUTO));

  TestCall call(small.NewChannel());
  v1::CloudHeader header = AutomaticHeader({});
  ASSERT_TRUE(call.SendHeader(header));
  EXPECT_EQ(call.ReadAccepted().options().automatic_scale().most_neighbor_count(), 100u);
  header.mutable_options()->mutable_automatic_scale()->set_most_neighbor_count(101);
  const CallResult refused = Estimate(small.NewChannel(), header, {});
  EXPECT_TRUE(FailedWith(refused, grpc::StatusCode::RESOURCE_EXHAUSTED, "NEIGHBORHOOD_TOO_LARGE",
                         {"most_neighbor_count is 101", "100"}));
}

}  // namespace
}  // namespace curvd
