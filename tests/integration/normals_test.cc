// Clouds without normals, or with normals to either side, through a real socket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "tests/integration/clouds.h"
#include "tests/integration/test_call.h"
#include "tests/integration/test_server.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using ::testing::UnorderedElementsAre;

class NormalsTest : public ::testing::Test {
 protected:
  CallResult Run(const v1::CloudHeader& header, const TestCloud& cloud) { return Estimate(channel_, header, cloud); }

  TestServer server_;
  std::shared_ptr<grpc::Channel> channel_ = server_.NewChannel();
};

v1::CloudHeader HeaderFor(const TestCloud& cloud, v1::NormalSource source) {
  v1::CloudHeader header = curvd::HeaderFor(cloud);
  header.mutable_normals()->set_source(source);
  return header;
}

v1::CloudHeader NormalsAlone(v1::CloudHeader header) {
  header.add_quantities(v1::QUANTITY_NORMALS);
  return header;
}

TestCloud WithoutNormals(TestCloud cloud) {
  cloud.normals.clear();
  return cloud;
}

// Every second normal negated.
TestCloud WithMixedSides(TestCloud cloud) {
  for (size_t i = 0; i < cloud.normals.size(); ++i) cloud.normals[i] *= i / 3 % 2 == 0 ? 1.0f : -1.0f;
  return cloud;
}

// Points whose normal in `result` points to the side of the cloud's own.
size_t RightSides(const CallResult& result, const TestCloud& cloud) {
  size_t right = 0;
  for (size_t i = 0; i < result.size(); ++i) {
    const auto normal = result.Normal(i);
    const float* truth = &cloud.normals[3 * i];
    right += normal[0] * truth[0] + normal[1] * truth[1] + normal[2] * truth[2] > 0.0f ? 1 : 0;
  }
  return right;
}

TEST_F(NormalsTest, PositionsAloneHaveTheCurvatureOfTheirSurface) {
  const TestCloud sphere = Sphere(20'000, 2.0f);
  const CallResult result = Run(HeaderFor(sphere, v1::NORMAL_SOURCE_ESTIMATE), WithoutNormals(sphere));
  ASSERT_TRUE(Succeeded(result, 20'000));
  EXPECT_EQ(result.point_status, std::string(20'000, kPointOk));
  EXPECT_NEAR(MeanOfMeans(result), 0.5, 0.005);  // 1 %: the estimator's bias at this K
  EXPECT_EQ(RightSides(result, sphere), 20'000u) << "the normals come without being asked for, and point outward";
  EXPECT_TRUE(result.normal_residual.empty());
  const v1::NormalsReport& report = result.summary->normals();
  EXPECT_NE(report.method(), v1::NORMAL_METHOD_UNSPECIFIED);
  EXPECT_GT(report.neighbor_count(), 0u);
  EXPECT_EQ(report.piece_count(), 1u);
  EXPECT_EQ(report.closed_piece_count(), 1u);
  ASSERT_TRUE(report.has_certificate());
  EXPECT_LT(report.certificate(), 0.25);
  EXPECT_FALSE(report.doubtful());
  EXPECT_EQ(result.summary->warnings_size(), 0);
  EXPECT_GT(result.summary->seconds().normals(), 0.0);
  EXPECT_GT(result.summary->seconds().orientation(), 0.0);
}

TEST_F(NormalsTest, NormalsToEitherSideAreTurned) {
  const TestCloud sphere = Sphere(20'000, 2.0f);
  const CallResult given = Run(HeaderFor(sphere, v1::NORMAL_SOURCE_GIVEN), sphere);
  const CallResult turned = Run(HeaderFor(sphere, v1::NORMAL_SOURCE_ORIENT), WithMixedSides(sphere));
  ASSERT_TRUE(Succeeded(given, 20'000));
  ASSERT_TRUE(Succeeded(turned, 20'000));
  EXPECT_EQ(turned.mean, given.mean) << "once turned, they are those of the other call";
  EXPECT_EQ(turned.d1, given.d1);
  EXPECT_EQ(RightSides(turned, sphere), 20'000u);
  EXPECT_EQ(turned.summary->normals().turned_count(), 10'000u);
  EXPECT_TRUE(given.normal.empty());
  EXPECT_FALSE(given.summary->has_normals());
}

TEST_F(NormalsTest, NormalsAloneTakeNoTimeForCurvature) {
  const TestCloud torus = Torus(20'000);
  v1::CloudHeader header = NormalsAlone(HeaderFor(torus, v1::NORMAL_SOURCE_ESTIMATE));
  header.add_quantities(v1::QUANTITY_NORMAL_QUALITY);
  const CallResult result = Run(header, WithoutNormals(torus));
  ASSERT_TRUE(Succeeded(result, 20'000));
  EXPECT_EQ(RightSides(result, torus), 20'000u);
  EXPECT_TRUE(result.mean.empty() && result.radius.empty());
  EXPECT_EQ(result.normal_residual.size(), 20'000 * sizeof(float));
  EXPECT_EQ(result.normal_variance_ratio.size(), 20'000 * sizeof(float));
  EXPECT_EQ(result.summary->seconds().estimate(), 0.0);
  server_.WaitForMetric(R"(curvd_phase_seconds_count{phase="normals"})", 1);
  server_.WaitForMetric(R"(curvd_phase_seconds_count{phase="orientation"})", 1);
  server_.WaitForMetric(R"(curvd_phase_seconds_count{phase="estimate"})", 0);
  server_.WaitForMetric(R"(curvd_points_total{status="ok"})", 20'000);

  v1::CloudHeader both = HeaderFor(torus, v1::NORMAL_SOURCE_ESTIMATE);
  EXPECT_EQ(Run(both, WithoutNormals(torus)).normal, result.normal) << "the same with curvature";
}

TEST_F(NormalsTest, GivenNormalsComeBackOnRequest) {
  TestCloud cloud = Sphere(100, 1.0f);
  const std::vector<float> unit = cloud.normals;
  for (float& scalar : cloud.normals) scalar *= 4.0f;
  v1::CloudHeader header = NormalsAlone(HeaderFor(cloud, v1::NORMAL_SOURCE_GIVEN));
  header.add_quantities(v1::QUANTITY_NORMAL_QUALITY);
  const CallResult result = Run(header, cloud);
  ASSERT_TRUE(Succeeded(result, 100));
  for (size_t i = 0; i < 100; ++i) EXPECT_NEAR(result.Normal(i)[0], unit[3 * i], 1e-6);
  EXPECT_FALSE(result.summary->has_normals());
}

TEST_F(NormalsTest, SidesFollowTheViewpointTheDirectionOrThePoints) {
  const TestCloud square = Square(2'000);
  v1::CloudHeader header = NormalsAlone(HeaderFor(square, v1::NORMAL_SOURCE_ESTIMATE));
  header.mutable_normals()->set_neighbor_count(20);
  const auto right = [&](TestCloud cloud) { return RightSides(Run(header, cloud), square); };
  header.mutable_normals()->set_orientation(v1::ORIENTATION_VIEWPOINT);
  header.mutable_normals()->mutable_viewpoint()->set_z(-3.0);
  EXPECT_EQ(right(WithoutNormals(square)), 0u);
  header.mutable_normals()->clear_viewpoint();
  header.mutable_normals()->set_orientation(v1::ORIENTATION_DIRECTION);
  header.mutable_normals()->mutable_direction()->set_z(0.1);
  EXPECT_EQ(right(WithoutNormals(square)), 2'000u);
  header.mutable_normals()->clear_direction();
  header.mutable_normals()->set_orientation(v1::ORIENTATION_POINT_VIEWPOINTS);
  TestCloud seen = WithoutNormals(square);
  for (size_t i = 0; i < 2'000; ++i) {
    seen.viewpoints.insert(seen.viewpoints.end(), {0.5f, 0.5f, i < 500 ? 1.0f : -1.0f});
  }
  EXPECT_EQ(right(seen), 500u);
}

TEST_F(NormalsTest, ViewpointsOfACloudOfUnknownSizeAreTaken) {
  TestCloud seen = WithoutNormals(Square(100'000));
  for (size_t i = 0; i < 100'000; ++i) seen.viewpoints.insert(seen.viewpoints.end(), {0.5f, 0.5f, -1.0f});
  v1::CloudHeader header = NormalsAlone(HeaderFor(seen, v1::NORMAL_SOURCE_ESTIMATE));
  header.set_point_count(0);
  header.mutable_normals()->set_neighbor_count(8);
  header.mutable_normals()->set_orientation(v1::ORIENTATION_POINT_VIEWPOINTS);
  const CallResult result = Estimate(channel_, header, seen, 7'000);
  ASSERT_TRUE(Succeeded(result, 100'000));
  EXPECT_EQ(RightSides(result, Square(100'000)), 0u);
}

TEST_F(NormalsTest, APointWithoutANormalSaysWhy) {
  TestCloud cloud = WithoutNormals(Sphere(2'000, 1.0f));
  std::fill(cloud.positions.begin(), cloud.positions.begin() + 300, 0.0f);  // a hundred at one place
  v1::CloudHeader header = HeaderFor(cloud, v1::NORMAL_SOURCE_ESTIMATE);
  header.mutable_normals()->set_neighbor_count(20);
  for (const bool alone : {false, true}) {
    const CallResult result = Run(alone ? NormalsAlone(header) : header, cloud);
    ASSERT_TRUE(Succeeded(result, 2'000));
    for (size_t i = 0; i < 100; ++i) {
      EXPECT_EQ(result.point_status[i], static_cast<char>(v1::POINT_STATUS_DEGENERATE_AREA));
      EXPECT_TRUE(std::isnan(result.Normal(i)[0]));
    }
    EXPECT_EQ(result.summary->status_counts().degenerate_area(), 100u);
    EXPECT_EQ(result.summary->normals().missing_count(), 100u);
  }
}

TEST_F(NormalsTest, WarnsWhereSidesCannotBeTrusted) {
  // A Moebius strip, which has one side alone.
  TestCloud strip;
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
  for (size_t i = 0; i < 4'000; ++i) {
    const float around = 3.1415927f * uniform(random);
    const float across = 0.4f * uniform(random);
    const float radius = 1.0f + across * std::cos(around / 2.0f);
    strip.Add(radius * std::cos(around), radius * std::sin(around), across * std::sin(around / 2.0f), 0.0f, 0.0f, 1.0f);
  }
  strip = WithoutNormals(strip);
  v1::CloudHeader header = NormalsAlone(HeaderFor(strip, v1::NORMAL_SOURCE_ESTIMATE));
  header.mutable_normals()->set_orientation(v1::ORIENTATION_CLOSED);
  const CallResult result = Run(header, strip);
  ASSERT_TRUE(Succeeded(result, 4'000));
  EXPECT_GT(result.summary->normals().certificate(), 0.25);
  EXPECT_TRUE(result.summary->normals().doubtful());
  ASSERT_EQ(result.summary->warnings_size(), 1);
  EXPECT_EQ(result.summary->warnings(0).code(), v1::WARNING_CODE_DOUBTFUL_ORIENTATION);
}

TEST_F(NormalsTest, AcceptedTellsWhereNormalsComeFrom) {
  TestCall call(channel_);
  v1::CloudHeader header;
  header.mutable_normals()->set_source(v1::NORMAL_SOURCE_ESTIMATE);
  header.mutable_normals()->set_neighbor_count(30);
  ASSERT_TRUE(call.SendHeader(header));
  const v1::Accepted accepted = call.ReadAccepted();
  EXPECT_EQ(accepted.normals().source(), v1::NORMAL_SOURCE_ESTIMATE);
  EXPECT_EQ(accepted.normals().method(), v1::NORMAL_METHOD_JET_2);
  EXPECT_EQ(accepted.normals().neighbor_count(), 30u);
  EXPECT_EQ(accepted.normals().orientation(), v1::ORIENTATION_CONSISTENT);
  EXPECT_EQ(accepted.quantities_size(), 6);
}

TEST_F(NormalsTest, FailsWhereNormalsAreMissingOrTooMany) {
  const TestCloud sphere = Sphere(100, 1.0f);
  EXPECT_TRUE(FailedWith(Run(HeaderFor(sphere, v1::NORMAL_SOURCE_GIVEN), WithoutNormals(sphere)),
                         grpc::StatusCode::INVALID_ARGUMENT, "CHUNK_LENGTH",
                         {"chunk.normals", "0 bytes", "header.normals.source"}));
  EXPECT_TRUE(FailedWith(Run(HeaderFor(sphere, v1::NORMAL_SOURCE_ESTIMATE), sphere), grpc::StatusCode::INVALID_ARGUMENT,
                         "CHUNK_LENGTH", {"chunk.normals", "1200 bytes", "absent"}));
}

TEST_F(NormalsTest, FailsWhereARadiusHoldsTooManyPoints) {
  TestServer small([](ServerOptions& options) { options.max_neighbor_count = 100; });
  const TestCloud sphere = Sphere(1'000, 1.0f);
  v1::CloudHeader header = NormalsAlone(HeaderFor(sphere, v1::NORMAL_SOURCE_ESTIMATE));
  header.mutable_normals()->set_radius(3.0);
  const CallResult result = Estimate(small.NewChannel(), header, WithoutNormals(sphere));
  EXPECT_TRUE(FailedWith(result, grpc::StatusCode::RESOURCE_EXHAUSTED, "NEIGHBORHOOD_TOO_LARGE", {"radius 3", "100"}));
  EXPECT_EQ(result.metadata.at("field"), "header.normals.radius");
}

// Normals that take several intervals of progress to make.
v1::CloudHeader SlowNormals(const TestCloud& cloud) {
  v1::CloudHeader header = NormalsAlone(HeaderFor(cloud, v1::NORMAL_SOURCE_ESTIMATE));
  header.mutable_normals()->set_method(v1::NORMAL_METHOD_JET_4);
  header.mutable_normals()->set_neighbor_count(600);
  return header;
}

TEST_F(NormalsTest, ProgressNamesThePhasesOfNormals) {
  const TestCloud torus = Torus(300'000);
  TestCall call(channel_);
  ASSERT_TRUE(call.SendHeader(SlowNormals(torus)));
  ASSERT_TRUE(call.SendCloud(WithoutNormals(torus), 50'000));
  call.HalfClose();
  std::set<v1::Progress::Phase> phases;
  while (const auto message = call.ReadAny()) {
    if (message->has_progress()) phases.insert(message->progress().phase());
  }
  EXPECT_EQ(phases.count(v1::Progress::PHASE_ESTIMATING), 0u);
  EXPECT_EQ(phases.count(v1::Progress::PHASE_ESTIMATING_NORMALS), 1u);
}

TEST_F(NormalsTest, ACancelStopsNormalsAndGivesTheirMemoryBack) {
  const TestCloud torus = Torus(300'000);
  TestCall call(channel_);
  ASSERT_TRUE(call.SendHeader(SlowNormals(torus)));
  ASSERT_TRUE(call.SendCloud(WithoutNormals(torus), 50'000));
  call.HalfClose();
  while (const auto message = call.ReadAny()) {
    if (message->has_progress() && message->progress().phase() == v1::Progress::PHASE_ESTIMATING_NORMALS) break;
  }
  call.Cancel();
  EXPECT_EQ(call.Finish().status.error_code(), grpc::StatusCode::CANCELLED);
  server_.WaitUntilIdle();
}

}  // namespace
}  // namespace curvd
