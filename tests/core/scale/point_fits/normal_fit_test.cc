#include "core/scale/point_fits/normal_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "Eigen/LU"
#include "Eigen/QR"

namespace curvd::testing {
namespace {

using Eigen::Vector3d;

constexpr double kAnyError = std::numeric_limits<double>::infinity();

// Neighbors of the origin, whose normal is that of z, sorted by distance.
class FittedNeighbors {
 public:
  void Add(double x, double y, const Vector3d& normal) { neighbors_.push_back({{x, y, 0.0}, normal}); }
  // What there is of the fit of the nearest `count`.
  std::optional<NormalFitWithBias> FitOf(size_t count, double allowed_error) const {
    return EstimateWithBias(NormalFrame(Vector3d::UnitZ()), Nearest(count), RadiusOf(count), allowed_error);
  }
  std::vector<const NeighborNormal*> Nearest(size_t count) const {
    std::vector<const NeighborNormal*> nearest;
    for (size_t i = 0; i < count; ++i) nearest.push_back(&neighbors_[i]);
    return nearest;
  }
  double RadiusOf(size_t count) const { return neighbors_[count - 1].offset.norm(); }
  size_t size() const { return neighbors_.size(); }

 private:
  std::vector<NeighborNormal> neighbors_;
};

using NormalField = std::function<Vector3d(double x, double y)>;

// On a spiral of so many points that fills the disc of that radius, or the part of it where x is positive.
FittedNeighbors OnDisc(size_t count, double radius, bool is_half, const NormalField& normal_at) {
  FittedNeighbors neighbors;
  const double of_disc = (is_half ? 2.0 : 1.0) * static_cast<double>(count);
  for (int i = 0; neighbors.size() < count; ++i) {
    const double r = radius * std::sqrt((i + 0.5) / of_disc), turn = 2.4 * i;
    const double x = r * std::cos(turn), y = r * std::sin(turn);
    if (!is_half || x > 0.0) neighbors.Add(x, y, normal_at(x, y));
  }
  return neighbors;
}

// On a sphere of radius 1, with noise.
NormalField OfSphere(double noise, unsigned seed) {
  std::mt19937_64 random(seed);
  return [random, noise](double x, double y) mutable {
    std::normal_distribution<double> normal(0.0, noise);
    const double z = std::sqrt(1.0 - x * x - y * y);
    return Vector3d(Vector3d(x + normal(random), y + normal(random), z + normal(random)).normalized());
  };
}

// On the graph of steep waves along x, with H = 2 at the origin.
Vector3d OfWaves(double x, double /*y*/) {
  constexpr double kFrequency = 15.0;
  return Vector3d(4.0 / kFrequency * std::sin(kFrequency * x), 0.0, 1.0).normalized();
}

// H by polynomials of one degree, and the standard error that chance makes of it.
struct ExpectedMean {
  double mean, error;
};

// By a decomposition of the weighted equations, one for each neighbor, instead of their sums.
ExpectedMean ExpectedInDegree(int degree, const FittedNeighbors& neighbors) {
  const double radius = neighbors.RadiusOf(neighbors.size());
  const auto count = static_cast<Eigen::Index>(neighbors.size());
  const int terms = kPolynomialTerms[static_cast<size_t>(degree)];
  Eigen::MatrixXd left(count, terms), right(count, 3);
  double weights = 0.0;
  Eigen::Index row = 0;
  const NormalFrame frame(Vector3d::UnitZ());
  for (const NeighborNormal* const neighbor : neighbors.Nearest(neighbors.size())) {
    const double x = frame.u.dot(neighbor->offset) / radius, y = frame.v.dot(neighbor->offset) / radius;
    const double weight = 1.0 - x * x - y * y, root = std::sqrt(std::max(weight, 0.0));
    left.row(row) = root * MonomialsAt<3>(x, y).head(terms).transpose();
    right.row(row++) = root * neighbor->normal.transpose();
    weights += weight;
  }
  const Eigen::MatrixXd fit = left.householderQr().solve(right);
  const double squares = (right - left * fit).squaredNorm();
  const Eigen::MatrixXd covariance = (left.transpose() * left).inverse();
  const double freedom = static_cast<double>(count - terms);
  // Along each of two tangents.
  const double variance = 0.5 * squares / weights * static_cast<double>(count) / freedom;
  const Vector3d value = fit.row(0), normal = value.normalized();
  // The trace of the change of the normal, over the tangents of the frame and of the normal itself.
  const Vector3d s = normal.unitOrthogonal(), t = normal.cross(s);
  double trace = 0.0;
  for (const Vector3d& tangent : {s, t}) {
    const Vector3d change = tangent.dot(frame.u) * fit.row(1) + tangent.dot(frame.v) * fit.row(2);
    trace += change.dot(tangent) / (value.norm() * radius);
  }
  return {0.5 * trace, 0.5 * std::sqrt(variance * (covariance(1, 1) + covariance(2, 2))) / radius};
}

// Beside a border each degree tells another curvature of normals that change like a cubic.
FittedNeighbors CubicWithNoise() {
  std::mt19937_64 random(1);
  return OnDisc(200, 0.1, true, [random](double x, double y) mutable {
    std::normal_distribution<double> normal(0.0, 0.01);
    return Vector3d(x + 10.0 * x * x - 150.0 * x * x * x + normal(random), y + normal(random), 1.0);
  });
}

TEST(PointNormalFitTest, DegreeFallsWithTheAllowedError) {
  const FittedNeighbors neighbors = CubicWithNoise();
  const ExpectedMean cubic = ExpectedInDegree(3, neighbors), quadratic = ExpectedInDegree(2, neighbors),
                     linear = ExpectedInDegree(1, neighbors);
  ASSERT_LT(quadratic.error, 0.9 * cubic.error);
  const auto mean_with = [&](double allowed_error) {
    const auto found = neighbors.FitOf(neighbors.size(), allowed_error);
    EXPECT_TRUE(found.has_value()) << allowed_error;
    return found.has_value() ? double{found->fit.point.mean} : kAnyError;
  };
  // Sums of products round to about 1e-9 of them, and results are floats.
  constexpr double kRounding = 1e-5, kBelow = 1.0 - 1e-6, kAbove = 1.0 + 1e-6;
  EXPECT_NEAR(mean_with(kAnyError), cubic.mean, kRounding);
  EXPECT_NEAR(mean_with(kAbove * cubic.error), cubic.mean, kRounding);
  EXPECT_NEAR(mean_with(kBelow * cubic.error), quadratic.mean, kRounding);
  EXPECT_NEAR(mean_with(kAbove * quadratic.error), quadratic.mean, kRounding);
  EXPECT_NEAR(mean_with(kBelow * quadratic.error), linear.mean, kRounding);
  EXPECT_NEAR(mean_with(0.0), linear.mean, kRounding) << "any error of degree 1 is allowed";
  for (const auto& [one, other] : {std::pair{cubic, quadratic}, {quadratic, linear}}) {
    ASSERT_GT(std::abs(one.mean - other.mean), 100.0 * kRounding);
  }
}

TEST(PointNormalFitTest, DegreeFallsWithTheNumberOfNeighbors) {
  // One more than coefficients at the least: nothing would tell the noise otherwise.
  const FittedNeighbors neighbors = CubicWithNoise();
  EXPECT_FALSE(EstimateWithBias(NormalFrame(Vector3d::UnitZ()), {}, 0.1, kAnyError).has_value());
  for (const size_t count : {1u, 3u}) EXPECT_FALSE(neighbors.FitOf(count, kAnyError).has_value()) << count;
  for (const auto& [count, degree] : {std::pair{size_t{5}, 1}, {6, 1}, {8, 2}, {10, 2}, {12, 3}}) {
    FittedNeighbors few;
    for (const NeighborNormal* const neighbor : neighbors.Nearest(count)) {
      few.Add(neighbor->offset.x(), neighbor->offset.y(), neighbor->normal);
    }
    const auto found = few.FitOf(count, kAnyError);
    ASSERT_TRUE(found.has_value()) << count;
    const ExpectedMean expected = ExpectedInDegree(degree, few);
    EXPECT_NEAR(found->fit.point.mean, expected.mean, 1e-4 * (1.0 + std::abs(expected.mean))) << count;
    EXPECT_EQ(found->fit.neighbor_count, count);
    // Seven in ten of them are too few for the fit that checks.
    EXPECT_EQ(found->bias_over_noise, 0.0) << count;
    EXPECT_NEAR(found->fit.mean_error, expected.error, 1e-4 * expected.error) << count;
  }
}

TEST(PointNormalFitTest, BiasOfASphereIsNoMoreThanNoise) {
  constexpr unsigned kSeeds = 100;
  double squares = 0.0, errors = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const auto found = OnDisc(200, 0.2, false, OfSphere(0.02, seed)).FitOf(200, kAnyError);
    ASSERT_TRUE(found.has_value()) << seed;
    squares += found->bias_over_noise * found->bias_over_noise / kSeeds;
    const double error = (found->fit.point.mean - 1.0) / found->fit.mean_error;
    errors += error * error / kSeeds;
    EXPECT_FALSE(found->fit.is_by_heights);
    EXPECT_GT(found->fit.k1_error, 0.0);
    EXPECT_GT(found->fit.k2_error, 0.0);
  }
  // Both fits share seven in ten neighbors: their difference is less than if they were independent.
  EXPECT_LT(squares, 1.0);
  EXPECT_GT(squares, 0.1);
  EXPECT_LT(errors, 1.3) << "standard errors are those of noise, and more";
  EXPECT_GT(errors, 0.3);
}

TEST(PointNormalFitTest, BiasOfWavesIsFarMoreThanNoise) {
  const FittedNeighbors neighbors = OnDisc(1000, 0.2, false, OfWaves);
  const auto found = neighbors.FitOf(neighbors.size(), kAnyError);
  ASSERT_TRUE(found.has_value());
  EXPECT_GT(found->bias_over_noise, 5.0);
  // What has been smoothed away is an error as well. It grows with the fourth power of the radius, so that the nearest
  // seven in ten neighbors have lost half as much, and tell the other half, a little less of steep waves.
  EXPECT_GT(found->fit.mean_error, 0.35 * std::abs(found->fit.point.mean - 2.0));
  const auto alone =
      EstimateByNormals(NormalFrame(Vector3d::UnitZ()), neighbors.Nearest(1000), neighbors.RadiusOf(1000), kAnyError);
  ASSERT_TRUE(alone.has_value());
  EXPECT_EQ(alone->point.mean, found->fit.point.mean);
  EXPECT_EQ(alone->mean_error, found->fit.mean_error);
}

}  // namespace
}  // namespace curvd::testing
