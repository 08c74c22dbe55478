#include "core/cloud/cloud.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/base/page_pool.h"

namespace curvd {
namespace {

template <typename Scalar>
std::string_view Bytes(const std::vector<Scalar>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Scalar)};
}

// `count` unit normals along z.
template <typename Scalar>
std::vector<Scalar> UpNormals(size_t count) {
  std::vector<Scalar> normals(3 * count, 0);
  for (size_t i = 0; i < count; ++i) normals[3 * i + 2] = 1;
  return normals;
}

TEST(CloudTest, KeepsFloatPositionsAsTheyAre) {
  Cloud cloud;
  ASSERT_TRUE(cloud.Append(Bytes<float>({1e6f, 0.1f, -3e-20f}), Bytes(UpNormals<float>(1))).ok());
  ASSERT_TRUE(cloud.Finish().ok());
  EXPECT_EQ(cloud.position(0), (std::array<float, 3>{1e6f, 0.1f, -3e-20f}));
}

TEST(CloudTest, AnExpectedCloudHoldsTheSamePoints) {
  for (const size_t count : {size_t{1}, Cloud::kBlockPoints, Cloud::kBlockPoints + 1, 3 * Cloud::kBlockPoints - 5}) {
    std::vector<float> positions(3 * count);
    for (size_t i = 0; i < positions.size(); ++i) positions[i] = static_cast<float>(i);
    const std::vector<float> normals = UpNormals<float>(count);
    Cloud cloud;
    cloud.Expect(count);
    constexpr size_t kChunk = 50'000;
    for (size_t first = 0; first < count; first += kChunk) {
      const size_t bytes = 12 * std::min(kChunk, count - first);
      ASSERT_TRUE(cloud.Append(Bytes(positions).substr(12 * first, bytes), Bytes(normals).substr(0, bytes)).ok());
    }
    ASSERT_TRUE(cloud.Finish().ok());
    ASSERT_EQ(cloud.size(), count);
    EXPECT_EQ(cloud.bytes(), kCloudBytesPerPoint * count);
    for (size_t i = 0; i < count; ++i) ASSERT_EQ(cloud.position(i)[2], static_cast<float>(3 * i + 2));
  }
}

// Room for many points, of which nobody knows whether they come, must not take the memory of those that did.
TEST(CloudTest, ACloudOfUnknownSizeTakesNoKeptPages) {
  ProcessPages().SetLimits({.kept = 64 << 20, .together = 64 << 20});
  const std::vector<float> normals = UpNormals<float>(1);
  for (const size_t expected : {Cloud::kBlockPoints, size_t{0}}) {
    const size_t kept = ProcessPages().kept_bytes();
    Cloud cloud;
    if (expected > 0) cloud.Expect(expected);
    ASSERT_TRUE(cloud.Append(Bytes(normals), Bytes(normals)).ok());
    EXPECT_EQ(ProcessPages().kept_bytes(), kept);
  }
  EXPECT_GT(ProcessPages().kept_bytes(), 0u);
  ProcessPages().SetLimits({});
}

TEST(CloudTest, GoesOnBehindARefusedFirstPoint) {
  for (const bool bare : {false, true}) {
    Cloud cloud(ScalarType::kFloat32, InvalidPointPolicy::kReject, bare ? NormalsInput::kAbsent : NormalsInput::kGiven);
    const auto append = [&](float x) {
      return cloud.Append(Bytes<float>({x, 2.0f, 3.0f}), bare ? std::string_view() : Bytes(UpNormals<float>(1)));
    };
    EXPECT_FALSE(append(std::numeric_limits<float>::quiet_NaN()).ok());
    ASSERT_TRUE(append(1.0f).ok());
    ASSERT_TRUE(cloud.Finish().ok());
    EXPECT_EQ(cloud.position(0), (std::array<float, 3>{1.0f, 2.0f, 3.0f}));
  }
}

TEST(CloudTest, RefusesMorePointsThanExpected) {
  Cloud cloud;
  cloud.Expect(2);
  const std::vector<float> normals = UpNormals<float>(2);
  ASSERT_TRUE(cloud.Append(Bytes(normals), Bytes(normals)).ok());
  const absl::Status status = cloud.Append(Bytes(normals), Bytes(normals));
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  EXPECT_NE(status.message().find("4 points; 2 were expected"), std::string::npos) << status;
  EXPECT_EQ(cloud.size(), 2u);
}

TEST(CloudTest, ShiftsDoublesToALocalOriginThatChunkingDoesNotChange) {
  constexpr size_t kPoints = 3000;
  std::vector<double> positions;
  for (size_t i = 0; i < 3 * kPoints; ++i) positions.push_back(5e6 + 1e-3 * static_cast<double>(i * 7919 % 1000));
  const std::vector<double> normals = UpNormals<double>(kPoints);
  std::vector<Cloud> clouds;
  for (size_t chunk : {size_t{1}, size_t{1000}, kPoints}) {
    Cloud cloud(ScalarType::kFloat64);
    for (size_t i = 0; i < kPoints; i += chunk) {
      const size_t bytes = chunk * 3 * sizeof(double);
      ASSERT_TRUE(cloud.Append(Bytes(positions).substr(i * 24, bytes), Bytes(normals).substr(i * 24, bytes)).ok());
    }
    ASSERT_TRUE(cloud.Finish().ok());
    clouds.push_back(std::move(cloud));
  }
  const auto& first = clouds[0];
  for (size_t i = 0; i < kPoints; ++i) {
    EXPECT_EQ(first.position(i), clouds[1].position(i));
    EXPECT_EQ(first.position(i), clouds[2].position(i));
    const double exact = positions[3 * i] - positions[0];
    // Rounded once, to 2^-24 of at most one unit's distance.
    EXPECT_NEAR(first.position(i)[0] - first.position(0)[0], exact, 0x1p-23);
  }
}

TEST(CloudTest, OneOutlierInFrontDoesNotMoveTheOrigin) {
  Cloud cloud(ScalarType::kFloat64);
  const std::vector<double> positions = {1e15, 1e15, 1e15, 5e6, 5e6, 5e6, 5e6 + 1e-3, 5e6, 5e6};
  ASSERT_TRUE(cloud.Append(Bytes(positions), Bytes(UpNormals<double>(3))).ok());
  ASSERT_TRUE(cloud.Finish().ok());
  EXPECT_NEAR(cloud.position(2)[0] - cloud.position(1)[0], 1e-3, 1e-9);
}

TEST(CloudTest, NormalizesNormalsOfAnyLengthAndCountsThem) {
  Cloud cloud;
  const std::vector<float> normals = {0, 0, 2, 0, 1e-30f, 0, 0, 3e38f, 0, 1, 0, 0};
  ASSERT_TRUE(cloud.Append(Bytes(std::vector<float>(12, 0.0f)), Bytes(normals)).ok());
  ASSERT_TRUE(cloud.Finish().ok());
  EXPECT_EQ(cloud.rescaled_count(), 3u);
  EXPECT_EQ(cloud.normal(0)[2], 1.0f);
  EXPECT_EQ(cloud.normal(1)[1], 1.0f);
  EXPECT_EQ(cloud.normal(2)[1], 1.0f);
}

TEST(CloudTest, NormalizesDoublesWhoseLengthOrItsInverseIsNone) {
  Cloud cloud(ScalarType::kFloat64);
  const std::vector<double> normals = {5e-324, 5e-324, 0, 0, -1e-310, 0, 1e308, 0, 1e308, 1.7e308, 1.7e308, 0};
  ASSERT_TRUE(cloud.Append(Bytes(std::vector<double>(12, 0.0)), Bytes(normals)).ok());
  ASSERT_TRUE(cloud.Finish().ok());
  const float diagonal = std::sqrt(0.5f);
  EXPECT_FLOAT_EQ(cloud.normal(0)[0], diagonal);
  EXPECT_FLOAT_EQ(cloud.normal(0)[1], diagonal);
  EXPECT_FLOAT_EQ(cloud.normal(1)[1], -1.0f);
  EXPECT_FLOAT_EQ(cloud.normal(2)[2], diagonal);
  EXPECT_FLOAT_EQ(cloud.normal(3)[0], diagonal);
}

TEST(CloudTest, RejectsInvalidPointsByIndexAndField) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Cloud cloud;
  ASSERT_TRUE(cloud.Append(Bytes(std::vector<float>(6, 0.0f)), Bytes(UpNormals<float>(2))).ok());
  absl::Status status = cloud.Append(Bytes<float>({0, nan, 0}), Bytes(UpNormals<float>(1)));
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("position of point 2"), std::string::npos) << status;
  status = cloud.Append(Bytes<float>({0, 0, 0}), Bytes<float>({0, 0, 0}));
  EXPECT_NE(status.message().find("normal of point 2"), std::string::npos) << status;
  EXPECT_EQ(cloud.size(), 2u);
}

TEST(CloudTest, SkipsInvalidPointsOnRequest) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (double bad : {infinity, std::nan(""), 1e300}) {  // 1e300 is no float after any shift
    Cloud cloud(ScalarType::kFloat64, InvalidPointPolicy::kSkip);
    std::vector<double> positions(9, 0.0);
    positions[3] = bad;
    ASSERT_TRUE(cloud.Append(Bytes(positions), Bytes(UpNormals<double>(3))).ok());
    ASSERT_TRUE(cloud.Finish().ok());
    EXPECT_EQ(cloud.invalid_count(), 1u);
    EXPECT_TRUE(std::isnan(cloud.position(1)[0]));
    EXPECT_EQ(cloud.size(), 3u);
  }
}

TEST(CloudTest, RejectsLengthsThatAreNoPoints) {
  Cloud cloud;
  const std::string bytes(25, '\0');
  EXPECT_EQ(cloud.Append(bytes, bytes).code(), absl::StatusCode::kInvalidArgument);
  const absl::Status status =
      cloud.Append(std::string_view(bytes).substr(0, 12), std::string_view(bytes).substr(0, 24));
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("24"), std::string::npos);
}

}  // namespace
}  // namespace curvd
