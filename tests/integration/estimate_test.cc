// Clouds of every kind through a real socket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "tests/integration/clouds.h"
#include "tests/integration/test_call.h"
#include "tests/integration/test_server.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

constexpr char kTooFew = static_cast<char>(v1::POINT_STATUS_TOO_FEW_NEIGHBORS);
constexpr char kDegenerate = static_cast<char>(v1::POINT_STATUS_DEGENERATE_AREA);
constexpr char kOpposed = static_cast<char>(v1::POINT_STATUS_OPPOSED_NORMALS);
constexpr char kInvalid = static_cast<char>(v1::POINT_STATUS_INVALID_INPUT);
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

class EstimateTest : public ::testing::Test {
 protected:
  CallResult Run(const v1::CloudHeader& header, const TestCloud& cloud) { return Estimate(channel_, header, cloud); }
  CallResult Run(const TestCloud& cloud, uint32_t k = 0) { return Run(HeaderFor(cloud, k), cloud); }

  TestServer server_;
  std::shared_ptr<grpc::Channel> channel_ = server_.NewChannel();
};

void ExpectAllNaN(const CallResult& result, size_t i) {
  EXPECT_TRUE(std::isnan(result.Mean(i)) && std::isnan(result.K1(i)) && std::isnan(result.K2(i))) << "point " << i;
}

TEST_F(EstimateTest, SphereHasTheInverseOfItsRadius) {
  const CallResult result = Run(Sphere(20'000, 2.0f));
  ASSERT_TRUE(Succeeded(result, 20'000));
  EXPECT_EQ(result.point_status, std::string(20'000, kPointOk));
  EXPECT_NEAR(MeanOfMeans(result), 0.5, 0.005);  // 1 %: the estimator's bias at this K
  for (size_t i = 0; i < result.size(); ++i) ASSERT_LE(result.K1(i), result.K2(i));
}

TEST_F(EstimateTest, NormalsThatContradictEachOtherAreAWarningOrAnError) {
  TestCloud cloud = Sphere(2'000, 1.0f);
  for (size_t i = 0; i < cloud.normals.size() / 2; ++i) cloud.normals[i] = -cloud.normals[i];
  const CallResult marked = Run(cloud);
  ASSERT_TRUE(Succeeded(marked, 2'000));
  const auto opposed = std::count(marked.point_status.begin(), marked.point_status.end(), kOpposed);
  EXPECT_GT(opposed, 0);
  EXPECT_LT(opposed, 2'000);
  EXPECT_EQ(marked.summary->status_counts().opposed_normals(), opposed);
  ASSERT_EQ(marked.summary->warnings_size(), 1);
  EXPECT_EQ(marked.summary->warnings(0).code(), v1::WARNING_CODE_OPPOSED_NORMALS);
  EXPECT_EQ(marked.summary->warnings(0).point_count(), opposed);
  EXPECT_EQ(marked.summary->warnings(0).flipped_patch_count(), 1u);
  for (size_t i = 0; i < marked.size(); ++i) {
    if (marked.point_status[i] == kOpposed) ExpectAllNaN(marked, i);
  }

  v1::CloudHeader header = HeaderFor(cloud);
  header.set_opposed_normals_policy(v1::OPPOSED_NORMALS_POLICY_REJECT);
  EXPECT_TRUE(FailedWith(Run(header, cloud), grpc::StatusCode::INVALID_ARGUMENT, "OPPOSED_NORMALS",
                         {"opposed to those of neighbors"}));
}

TEST_F(EstimateTest, FloatsFarFromZeroAreAWarning) {
  TestCloud cloud = Sphere(2'000, 1.0f);
  EXPECT_EQ(Run(cloud).summary->warnings_size(), 0);
  for (size_t i = 0; i < cloud.positions.size(); i += 3) {
    cloud.positions[i] += 5e5f;
    cloud.positions[i + 1] += 5e6f;
  }
  v1::CloudHeader header = HeaderFor(cloud);
  header.set_invalid_point_policy(v1::INVALID_POINT_POLICY_SKIP);
  const CallResult result = Run(header, cloud);
  ASSERT_TRUE(Succeeded(result, 2'000));
  ASSERT_GE(result.summary->warnings_size(), 1);
  EXPECT_EQ(result.summary->warnings(0).code(), v1::WARNING_CODE_COARSE_POSITIONS);
  EXPECT_THAT(result.summary->warnings(0).message(), ::testing::HasSubstr("near 5e+06, which lie 0.5 apart there"));
}

TEST_F(EstimateTest, NormalsThatDoNotFitThePositionsAreAWarning) {
  TestCloud cloud = Sphere(2'000, 1.0f);
  for (size_t i = 0; i < cloud.normals.size(); i += 3)
    std::rotate(&cloud.normals[i], &cloud.normals[i + 1], cloud.normals.data() + i + 3);
  const CallResult result = Run(cloud);
  ASSERT_TRUE(Succeeded(result, 2'000));
  ASSERT_GE(result.summary->warnings_size(), 1);
  EXPECT_EQ(result.summary->warnings(0).code(), v1::WARNING_CODE_NORMALS_OFF_SURFACE);
}

TEST_F(EstimateTest, AcceptedTellsOptionsLimitsAndRequestId) {
  TestCall call(channel_);
  ASSERT_TRUE(call.SendHeader({}));
  const v1::Accepted accepted = call.ReadAccepted();
  EXPECT_THAT(accepted.request_id(), ::testing::MatchesRegex("[0-9a-f]+-[0-9]+"));
  EXPECT_EQ(accepted.options().estimator(), v1::ESTIMATOR_AVG_HEXAGRAM);
  EXPECT_EQ(accepted.options().neighbor_count(), 50u);
  EXPECT_EQ(accepted.limits().max_chunk_bytes(), 4u << 20);
  EXPECT_EQ(accepted.quantities_size(), 5);
}

TEST_F(EstimateTest, EveryEstimatorWorks) {
  const TestCloud cloud = Sphere(2'000, 1.0f);
  for (const v1::Estimator estimator : {v1::ESTIMATOR_AVG_HEXAGRAM, v1::ESTIMATOR_HEXAGRAM, v1::ESTIMATOR_UNIFORM,
                                        v1::ESTIMATOR_INDEPENDENT, v1::ESTIMATOR_DELAUNAY, v1::ESTIMATOR_JET_FITTING,
                                        v1::ESTIMATOR_ALGEBRAIC_SHAPE_OPERATOR, v1::ESTIMATOR_NORMAL_REGRESSION}) {
    v1::CloudHeader header = HeaderFor(cloud);
    header.mutable_options()->set_estimator(estimator);
    const CallResult result = Run(header, cloud);
    ASSERT_TRUE(Succeeded(result, 2'000)) << v1::Estimator_Name(estimator);
    EXPECT_NEAR(MeanOfMeans(result), 1.0, 0.1) << v1::Estimator_Name(estimator);  // coarse: every strategy is close
  }
}

TEST_F(EstimateTest, DelaunayTakesEvenWeights) {
  const TestCloud cloud = Torus(1'000);
  v1::CloudHeader header = HeaderFor(cloud, 20);
  header.mutable_options()->set_estimator(v1::ESTIMATOR_DELAUNAY);
  const CallResult falling = Run(header, cloud);
  header.mutable_options()->set_even_weights(true);
  const CallResult even = Run(header, cloud);
  ASSERT_TRUE(Succeeded(falling, 1'000));
  ASSERT_TRUE(Succeeded(even, 1'000));
  EXPECT_NE(even.mean, falling.mean);
}

TEST_F(EstimateTest, SendsOnlyTheQuantitiesThatWereAskedFor) {
  const TestCloud cloud = Sphere(100, 1.0f);
  v1::CloudHeader header = HeaderFor(cloud, 10);
  header.add_quantities(v1::QUANTITY_GAUSSIAN_CURVATURE);
  const CallResult result = Run(header, cloud);
  ASSERT_TRUE(Succeeded(result, 100));
  EXPECT_EQ(result.gaussian.size(), 400u);
  EXPECT_TRUE(result.mean.empty() && result.k1.empty() && result.d1.empty() && result.radius.empty());
}

TEST_F(EstimateTest, AcceptsACloudOfUnknownSize) {
  const TestCloud cloud = Sphere(1'000, 1.0f);
  v1::CloudHeader header = HeaderFor(cloud);
  const std::string known = Run(header, cloud).AllBytes();
  header.clear_point_count();
  const CallResult unknown = Estimate(channel_, header, cloud, 100);
  ASSERT_TRUE(Succeeded(unknown, 1'000));
  EXPECT_EQ(unknown.AllBytes(), known);
}

TEST_F(EstimateTest, RadiusNeighborhoodReportsItsRadius) {
  const TestCloud cloud = Sphere(2'000, 1.0f);
  v1::CloudHeader header = HeaderFor(cloud);
  header.mutable_options()->set_radius(0.25);
  const CallResult result = Run(header, cloud);
  ASSERT_TRUE(Succeeded(result, 2'000));
  EXPECT_NEAR(MeanOfMeans(result), 1.0, 0.05);
  float radius = 0.0f;
  std::memcpy(&radius, result.radius.data(), sizeof(radius));
  EXPECT_EQ(radius, 0.25f);
}

TEST_F(EstimateTest, OnePointHasTooFewNeighbors) {
  const CallResult result = Run(Sphere(1, 1.0f));
  ASSERT_TRUE(Succeeded(result, 1));
  EXPECT_EQ(result.point_status, std::string(1, kTooFew));
  ExpectAllNaN(result, 0);
}

TEST_F(EstimateTest, NoPointsIsAnEmptyResult) {
  const CallResult result = Run(TestCloud());
  ASSERT_TRUE(Succeeded(result, 0));
  EXPECT_EQ(result.summary->point_count(), 0u);
}

TEST_F(EstimateTest, FewerThanKPointsHaveTooFewNeighbors) {
  const CallResult result = Run(Sphere(49, 1.0f), 50);
  ASSERT_TRUE(Succeeded(result, 49));
  EXPECT_EQ(result.point_status, std::string(49, kTooFew));
  EXPECT_EQ(result.summary->status_counts().too_few_neighbors(), 49u);
  for (size_t i = 0; i < result.size(); ++i) ExpectAllNaN(result, i);
}

TEST_F(EstimateTest, ExactlyKPointsAreEnough) {
  const CallResult result = Run(Sphere(50, 1.0f), 50);
  ASSERT_TRUE(Succeeded(result, 50));
  EXPECT_EQ(result.summary->status_counts().too_few_neighbors(), 0u);
}

TEST_F(EstimateTest, EqualPointsHaveNoArea) {
  TestCloud cloud;
  for (int i = 0; i < 200; ++i) cloud.Add(1, 2, 3, 0, 0, 1);
  const CallResult result = Run(cloud, 20);
  ASSERT_TRUE(Succeeded(result, 200));
  EXPECT_EQ(result.point_status, std::string(200, kDegenerate));
  for (size_t i = 0; i < result.size(); ++i) ExpectAllNaN(result, i);
}

TEST_F(EstimateTest, APlaneIsFlat) {
  const CallResult result = Run(Square(2'000), 20);
  ASSERT_TRUE(Succeeded(result, 2'000));
  for (size_t i = 0; i < result.size(); ++i) {
    if (result.point_status[i] != kPointOk) continue;
    ASSERT_EQ(result.Mean(i), 0.0f) << "normals are all equal, so that nothing turns";
    ASSERT_EQ(result.K1(i), 0.0f);
  }
  EXPECT_GT(result.summary->status_counts().ok(), 1'900u);
}

TEST_F(EstimateTest, DuplicatesDoNotSpoilACloud) {
  TestCloud cloud = Sphere(2'000, 1.0f);
  for (size_t i = 0; i < 2'000; ++i) {
    cloud.Add(cloud.positions[3 * i], cloud.positions[3 * i + 1], cloud.positions[3 * i + 2], cloud.normals[3 * i],
              cloud.normals[3 * i + 1], cloud.normals[3 * i + 2]);
  }
  const CallResult result = Run(cloud);
  ASSERT_TRUE(Succeeded(result, 4'000));
  EXPECT_EQ(result.summary->status_counts().ok(), 4'000u);
  EXPECT_NEAR(MeanOfMeans(result), 1.0, 0.05);
}

TEST_F(EstimateTest, RejectsTheFirstInvalidPointByItsIndex) {
  for (const float bad : {kNaN, kInfinity, -kInfinity}) {
    TestCloud cloud = Sphere(500, 1.0f);
    cloud.positions[3 * 321 + 1] = bad;
    EXPECT_TRUE(FailedWith(Run(cloud), grpc::StatusCode::INVALID_ARGUMENT, "INVALID_POINT",
                           {"321", std::isnan(bad) ? "nan" : "inf"}));
    cloud = Sphere(500, 1.0f);
    cloud.normals[3 * 123 + 2] = bad;
    EXPECT_TRUE(FailedWith(Run(cloud), grpc::StatusCode::INVALID_ARGUMENT, "INVALID_POINT",
                           {"123", "normal", std::isnan(bad) ? "nan" : "inf"}));
  }
}

TEST_F(EstimateTest, RejectsAZeroNormal) {
  TestCloud cloud = Sphere(500, 1.0f);
  for (int axis = 0; axis < 3; ++axis) cloud.normals[3 * 77 + axis] = 0.0f;
  EXPECT_TRUE(FailedWith(Run(cloud), grpc::StatusCode::INVALID_ARGUMENT, "INVALID_POINT", {"77", "normal"}));
}

TEST_F(EstimateTest, SkippedPointsAreNobodysNeighbors) {
  TestCloud cloud = Sphere(2'000, 1.0f);
  const TestCloud clean = cloud;
  const CallResult expected = Run(clean);
  cloud.Add(kNaN, 0, 0, 0, 0, 1);
  cloud.Add(0, 0, kInfinity, 0, 0, 1);
  cloud.Add(0, 0, 1, 0, 0, 0);
  cloud.Add(0, 0, 1, kNaN, 0, 0);
  v1::CloudHeader header = HeaderFor(cloud);
  header.set_invalid_point_policy(v1::INVALID_POINT_POLICY_SKIP);
  const CallResult result = Run(header, cloud);
  ASSERT_TRUE(Succeeded(result, 2'004));
  EXPECT_EQ(result.point_status.substr(2'000), std::string(4, kInvalid));
  EXPECT_TRUE(result.mean.substr(0, 8'000) == expected.mean);
  for (size_t i = 2'000; i < 2'004; ++i) ExpectAllNaN(result, i);
}

TEST_F(EstimateTest, AllPointsMayBeSkipped) {
  TestCloud cloud;
  for (int i = 0; i < 100; ++i) cloud.Add(kNaN, kNaN, kNaN, 0, 0, 0);
  v1::CloudHeader header = HeaderFor(cloud);
  header.set_invalid_point_policy(v1::INVALID_POINT_POLICY_SKIP);
  const CallResult result = Run(header, cloud);
  ASSERT_TRUE(Succeeded(result, 100));
  EXPECT_EQ(result.point_status, std::string(100, kInvalid));
}

TEST_F(EstimateTest, NormalsOfAnyLengthCountAsDirections) {
  TestCloud cloud = Sphere(2'000, 1.0f);
  const CallResult expected = Run(cloud);
  for (float& component : cloud.normals) component *= 2.0f;
  const CallResult result = Run(cloud);
  ASSERT_TRUE(Succeeded(result, 2'000));
  EXPECT_EQ(result.summary->normals_rescaled(), 2'000u);
  EXPECT_EQ(expected.summary->normals_rescaled(), 0u);
  EXPECT_NEAR(MeanOfMeans(result), MeanOfMeans(expected), 1e-6);  // float rounding of the unit normals
}

TEST_F(EstimateTest, FlippedNormalsFlipTheSign) {
  TestCloud cloud = Sphere(2'000, 1.0f);
  for (float& component : cloud.normals) component = -component;
  const CallResult result = Run(cloud);
  ASSERT_TRUE(Succeeded(result, 2'000));
  EXPECT_NEAR(MeanOfMeans(result), -1.0, 0.02);
}

TEST_F(EstimateTest, AFlippedNormalCostsThoseAroundItAlone) {
  TestCloud cloud = Sphere(2'000, 1.0f);
  const CallResult expected = Run(cloud);
  for (int axis = 0; axis < 3; ++axis) cloud.normals[3 * 1'000 + axis] *= -1.0f;
  const CallResult result = Run(cloud);
  ASSERT_TRUE(Succeeded(result, 2'000));
  // 50 neighbors, and as many have it as a neighbor.
  EXPECT_NEAR(static_cast<double>(result.summary->status_counts().opposed_normals()), 50.0, 5.0);
  for (size_t i = 0; i < result.size(); ++i) {
    if (result.point_status[i] == kOpposed) continue;
    ASSERT_EQ(result.point_status[i], kPointOk);
    ASSERT_EQ(result.Mean(i), expected.Mean(i));
  }
}

TEST_F(EstimateTest, OneOutlierDoesNotTouchTheRest) {
  TestCloud cloud = Sphere(5'000, 1.0f);
  const CallResult expected = Run(cloud);
  cloud.Add(1e6f, 1e6f, 1e6f, 0, 0, 1);
  const CallResult result = Run(cloud);
  ASSERT_TRUE(Succeeded(result, 5'001));
  EXPECT_EQ(result.point_status.substr(0, 5'000), expected.point_status);
  for (size_t i = 0; i < 5'000; ++i) {
    ASSERT_NEAR(result.Mean(i), expected.Mean(i), 1e-5);  // the order of the sums may differ
  }
}

TEST_F(EstimateTest, HalfOfTheCloudInOneSpotIsNoProblem) {
  TestCloud cloud = Sphere(5'000, 1.0f);
  const TestCloud dense = Sphere(5'000, 1e-4f);
  cloud.positions.insert(cloud.positions.end(), dense.positions.begin(), dense.positions.end());
  cloud.normals.insert(cloud.normals.end(), dense.normals.begin(), dense.normals.end());
  const CallResult result = Run(cloud);
  ASSERT_TRUE(Succeeded(result, 10'000));
  EXPECT_EQ(result.summary->status_counts().ok(), 10'000u);
  EXPECT_NEAR(result.Mean(0), 1.0, 0.05);
  EXPECT_NEAR(result.Mean(7'500), 1e4, 500.0);
}

TEST_F(EstimateTest, Float64KeepsCoordinatesFarFromZero) {
  const TestCloud cloud = Sphere(2'000, 1.0f);
  std::vector<double> positions(cloud.positions.begin(), cloud.positions.end());
  for (double& coordinate : positions) coordinate += 5e6;
  const std::vector<double> normals(cloud.normals.begin(), cloud.normals.end());
  v1::CloudHeader header = HeaderFor(cloud);
  header.set_scalar_type(v1::SCALAR_TYPE_FLOAT64);
  TestCall call(channel_);
  ASSERT_TRUE(call.SendHeader(header));
  TestCall::Request message;
  message.mutable_chunk()->set_positions(positions.data(), positions.size() * sizeof(double));
  message.mutable_chunk()->set_normals(normals.data(), normals.size() * sizeof(double));
  ASSERT_TRUE(call.Send(message));
  call.HalfClose();
  const CallResult result = call.Finish();
  ASSERT_TRUE(Succeeded(result, 2'000));
  EXPECT_NEAR(MeanOfMeans(result), 1.0, 0.02);
}

TEST_F(EstimateTest, WorksWithoutASocket) {
  const TestCloud cloud = Sphere(1'000, 1.0f);
  const CallResult by_socket = Run(cloud);
  const CallResult in_process = Estimate(server_.server().InProcessChannel(), HeaderFor(cloud), cloud);
  ASSERT_TRUE(Succeeded(in_process, 1'000));
  EXPECT_EQ(in_process.AllBytes(), by_socket.AllBytes());
}

}  // namespace
}  // namespace curvd
