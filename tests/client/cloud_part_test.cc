// A cloud that is sent in tiles, through a real server, has the bytes of the whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "client/curvature_client.h"
#include "tests/client/local_server.h"

namespace curv {
namespace {

constexpr double kSide = 64.0;
constexpr double kFar[3] = {432'000.5, 5'300'000.25, 812.125};

struct Points {
  std::vector<double> positions, normals;
  std::vector<uint64_t> ids;
  std::vector<PointRole> roles;

  size_t size() const { return ids.size(); }
  double x(size_t i) const { return positions[3 * i]; }
  void Take(const Points& from, size_t i, PointRole role) {
    for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
      positions.push_back(from.positions[c]);
      normals.push_back(from.normals[c]);
    }
    ids.push_back(from.ids[i]);
    roles.push_back(role);
  }
  CloudView View() const { return CloudView(positions, normals).WithIds(ids).WithRoles(roles); }
};

// Hills far from zero, denser where x is small, with ids that say nothing about the order.
Points Hills(size_t count) {
  Points points;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (size_t i = 0; i < count; ++i) {
    const double u = unit(random), x = kSide * u * std::sqrt(u), y = kSide * unit(random) / 2;
    points.positions.insert(points.positions.end(),
                            {kFar[0] + x, kFar[1] + y, kFar[2] + 2.0 * std::sin(x / 6.0) * std::cos(y / 5.0)});
    points.normals.insert(points.normals.end(), {-std::cos(x / 6.0) * std::cos(y / 5.0) / 3.0,
                                                 0.4 * std::sin(x / 6.0) * std::sin(y / 5.0), 1.0});
    points.ids.push_back((i * 0x9E3779B97F4A7C15u) | 1);
    points.roles.push_back(PointRole::kQuery);
  }
  return points;
}

// All arrays of result i, one after the other.
std::vector<uint8_t> BytesOf(const CurvatureResult& result, size_t i) {
  std::vector<uint8_t> bytes = {result.status[i]};
  const auto add = [&](const std::vector<float>& values, size_t width) {
    const auto* first = reinterpret_cast<const uint8_t*>(values.data() + i * width);
    bytes.insert(bytes.end(), first, first + width * sizeof(float));
  };
  for (const auto* values : {&result.mean, &result.gaussian, &result.k1, &result.k2, &result.radius}) add(*values, 1);
  for (const auto* values : {&result.d1, &result.d2}) add(*values, 3);
  return bytes;
}

class CloudPartTest : public ::testing::TestWithParam<Estimator> {};

TEST_P(CloudPartTest, TilesHaveTheBytesOfTheWholeCloud) {
  const auto server = StartServer();
  const auto client = CurvatureClient::Connect(AddressOf(server->port()));
  ASSERT_TRUE(client.ok());
  const Points cloud = Hills(5'000);
  EstimateOptions options;
  options.estimator = GetParam();
  options.neighbor_count = 35;
  constexpr double kSpacing = 0x1p-10;
  options.lattice = PositionLattice{kSpacing, {kFar[0], kFar[1], kFar[2]}};
  const auto whole = (*client)->Estimate(cloud.View(), options);
  ASSERT_TRUE(whole.ok()) << whole.status();
  ASSERT_TRUE(whole->summary.reach_factor.has_value());
  const double reach = *whole->summary.reach_factor;
  const double halo = 4.5 * reach;
  std::mt19937_64 random(5);
  size_t certified = 0;
  constexpr int kTiles = 3;
  for (int tile = 0; tile < kTiles; ++tile) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const double lo = tile == 0 ? -kInfinity : kFar[0] + kSide * tile / kTiles;
    const double hi = tile + 1 == kTiles ? kInfinity : kFar[0] + kSide * (tile + 1) / kTiles;
    std::vector<size_t> order(cloud.size()), queries;
    std::iota(order.begin(), order.end(), size_t{0});
    std::shuffle(order.begin(), order.end(), random);
    Points part;
    for (const size_t i : order) {
      if (cloud.x(i) < lo - halo || cloud.x(i) > hi + halo) continue;
      const bool is_query = cloud.x(i) >= lo && cloud.x(i) < hi;
      part.Take(cloud, i, is_query ? PointRole::kQuery : PointRole::kHalo);
      if (is_query) queries.push_back(i);
    }
    options.lattice->origin = {kFar[0] + 8.0 * tile, kFar[1] - tile, kFar[2]};
    const auto result = (*client)->Estimate(part.View(), options);
    ASSERT_TRUE(result.ok()) << result.status();
    ASSERT_EQ(result->status.size(), queries.size());
    EXPECT_EQ(result->summary.points, part.size());
    for (size_t q = 0; q < queries.size(); ++q) {
      // Snapping moves points by half a spacing.
      const double x = cloud.x(queries[q]), depth = std::min(x - lo, hi - x) + halo - 2 * kSpacing;
      if (!(reach * result->radius[q] * (1 + 1e-6) < depth)) continue;
      ++certified;
      ASSERT_EQ(BytesOf(*result, q), BytesOf(*whole, queries[q])) << "point " << queries[q];
    }
  }
  EXPECT_GT(certified, cloud.size() * 9 / 10);
}

INSTANTIATE_TEST_SUITE_P(Estimators, CloudPartTest,
                         ::testing::Values(Estimator::kAvgHexagram, Estimator::kHexagram, Estimator::kUniform,
                                           Estimator::kIndependent, Estimator::kDelaunay, Estimator::kJetFitting,
                                           Estimator::kAlgebraicShapeOperator, Estimator::kNormalRegression));

TEST(CloudPartClientTest, ArraysOfAnotherSizeAreRefused) {
  const auto server = StartServer();
  const auto client = CurvatureClient::Connect(AddressOf(server->port()));
  ASSERT_TRUE(client.ok());
  const Points cloud = Hills(100);
  const std::vector<uint64_t> ids(99);
  const std::vector<PointRole> roles(101, PointRole::kQuery);
  const CloudView view(cloud.positions, cloud.normals);
  EXPECT_EQ((*client)->Estimate(view.WithIds(ids), {}).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ((*client)->Estimate(view.WithRoles(roles), {}).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(CloudPartClientTest, TheServerNamesPointsOfOneId) {
  const auto server = StartServer();
  const auto client = CurvatureClient::Connect(AddressOf(server->port()));
  ASSERT_TRUE(client.ok());
  Points cloud = Hills(100);
  cloud.ids[70] = cloud.ids[20] = 5;
  const absl::Status status = (*client)->Estimate(cloud.View(), {}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("ids of points 20 and 70 are both 5"), std::string::npos) << status;
  EXPECT_EQ(ErrorReason(status), "INVALID_POINT");
}

TEST(CloudPartClientTest, TheServerNamesAPointThatIsOffTheLattice) {
  const auto server = StartServer();
  const auto client = CurvatureClient::Connect(AddressOf(server->port()));
  ASSERT_TRUE(client.ok());
  const Points cloud = Hills(100);
  EstimateOptions options;
  options.lattice = PositionLattice{0x1p-10, {0, 0, 0}};
  const absl::Status status = (*client)->Estimate(cloud.View(), options).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("position of point 0 is (432"), std::string::npos) << status;
  options.lattice = PositionLattice{0.001, {0, 0, 0}};
  const absl::Status spacing = (*client)->Estimate(cloud.View(), options).status();
  EXPECT_NE(spacing.message().find("lattice.spacing is 0.001; it must be a power of two"), std::string::npos) << spacing;
}

}  // namespace
}  // namespace curv
