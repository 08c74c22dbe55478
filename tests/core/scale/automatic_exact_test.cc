// The automatic choice where positions are exact.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/core/scale/automatic_requests.h"
#include "tests/core/seam_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// Exact positions are worth more than their normals, and a polynomial of a high degree makes the most of them.
TEST(AutomaticExactTest, ExactPositionsBeatEveryFixedEstimator) {
  constexpr double kAxes[3] = {2.0, 1.5, 1.0};
  TestPoints ellipsoid = Sphere(8000, 1.0);
  std::vector<double> truth;
  for (size_t i = 0; i < ellipsoid.size(); ++i) {
    double length = 0.0, squared = 0.0, volume = 1.0, axes = 0.0, normal[3];
    for (size_t axis = 0; axis < 3; ++axis) {
      float& position = ellipsoid.positions[i][axis];
      normal[axis] = double{position} / kAxes[axis];
      position = static_cast<float>(position * kAxes[axis]);
      squared += double{position} * double{position};
      length += normal[axis] * normal[axis];
      axes += kAxes[axis] * kAxes[axis];
      volume *= kAxes[axis];
    }
    length = std::sqrt(length);
    for (size_t axis = 0; axis < 3; ++axis) ellipsoid.normals[i][axis] = static_cast<float>(normal[axis] / length);
    truth.push_back((axes - squared) / (2.0 * volume * volume * length * length * length));
  }
  AddNoise(0.0, 0.05, 3, ellipsoid);
  const auto mean_error = [&](const EstimatorOptions& options) {
    const EstimationResult result = MustEstimate(ellipsoid.ToCloud(), options);
    double sum = 0.0;
    for (size_t i = 0; i < truth.size(); ++i) {
      const PointCurvature& point = result.field.points[i];
      EXPECT_EQ(point.status, PointStatus::kOk);
      sum += std::abs(point.mean - truth[i]);
    }
    return sum / static_cast<double>(truth.size());
  };
  double best = 1.0;
  for (const uint32_t count : {16u, 23u, 32u}) {
    best = std::min(best, mean_error({.estimator = "jet", .neighborhood = NeighborCount{count}, .jet_degree = 4}));
  }
  EXPECT_LT(mean_error(Automatic()), 0.5 * best);
}

// All normals lean to one side, as those of a scanner that is out of true: they agree with each other at every scale,
// and with the positions nowhere.
TEST(AutomaticExactTest, NormalsThatLeanAreNotTrustedBesideExactPositions) {
  constexpr float kLean = 0.04f;
  TestPoints sphere = Sphere(4000, 1.0);
  for (std::array<float, 3>& n : sphere.normals) {
    const float along = n[2];
    for (size_t axis = 0; axis < 3; ++axis) n[axis] += kLean * ((axis == 2 ? 1.0f : 0.0f) - along * n[axis]);
    const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (float& component : n) component /= length;
  }
  const EstimationResult result = MustEstimate(sphere.ToCloud(), Automatic());
  // The divergence of the normals alone is off by 0.02 in the mean.
  EXPECT_LT(MeanError(result, 1.0), 0.001);
}

}  // namespace
}  // namespace curvd::testing
