#include "core/estimators/lines/line_test.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/estimators/lines/curve_distance.h"
#include "tests/core/instruction_sets.h"

namespace curvd {
namespace {

struct Offsets {
  NeighborOffsets neighbors;

  explicit Offsets(size_t size) { neighbors.Reserve(size); }
  void Add(double x, double y, double z) {
    neighbors.x[neighbors.count] = static_cast<float>(x);
    neighbors.y[neighbors.count] = static_cast<float>(y);
    neighbors.z[neighbors.count++] = static_cast<float>(z);
  }
};

// Points on an arc with the turn `bend` over radius 1 in the plane z = 0, moved along y and z.
Offsets Arc(size_t size, double bend, double across, double thickness) {
  std::mt19937_64 engine(2);
  std::normal_distribution<double> normal;
  Offsets arc(size);
  for (size_t i = 0; i < size; ++i) {
    const double x = 2.0 * static_cast<double>(i) / static_cast<double>(size - 1) - 1.0;
    arc.Add(x, 0.5 * bend * x * x + across * normal(engine), thickness * normal(engine));
  }
  return arc;
}

constexpr float kUp[3] = {0.0f, 0.0f, 1.0f};

bool IsLine(const Offsets& offsets) { return MeasureLine(offsets.neighbors, kUp, 1.0f, false).IsLine(); }

TEST(LineTest, NoiseDoesNotWidenALine) {
  EXPECT_TRUE(IsLine(Arc(50, 0.0, 0.02, 0.02)));
  EXPECT_TRUE(IsLine(Arc(50, 0.0, 0.001, 0.0))) << "a hair";
  EXPECT_FALSE(IsLine(Arc(50, 0.0, 0.02, 0.002))) << "wider than its noise: a strip";
  EXPECT_FALSE(IsLine(Arc(50, 0.0, 0.2, 0.2))) << "not narrow";
}

TEST(LineTest, ALineMayBend) { EXPECT_TRUE(IsLine(Arc(50, 0.4, 0.005, 0.005))); }

TEST(LineTest, DependsOnNoOrder) {
  Offsets arc = Arc(50, 0.1, 0.02, 0.02);
  const LineSpread before = MeasureLine(arc.neighbors, kUp, 1.0f, true);
  for (auto* array : {&arc.neighbors.x, &arc.neighbors.y, &arc.neighbors.z}) {
    std::reverse(array->data(), array->data() + arc.neighbors.count);
  }
  const LineSpread after = MeasureLine(arc.neighbors, kUp, 1.0f, true);
  EXPECT_EQ(before.along, after.along);
  EXPECT_EQ(before.across, after.across);
  EXPECT_EQ(before.thickness, after.thickness);
}

// What a polynomial of the given degree, at most 2, over x leaves of values: the root of the mean square. All weighted.
double Rest(const Eigen::VectorXd& x, const Eigen::VectorXd& values, const Eigen::VectorXd& weights, int degree) {
  // Powers that are left out stay with a one on the diagonal, and get nothing.
  Eigen::Matrix3d products = Eigen::Vector3d(0.0, degree > 0 ? 0.0 : 1.0, degree > 1 ? 0.0 : 1.0).asDiagonal();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  const auto powers_at = [&](Eigen::Index i) {
    return Eigen::Vector3d(1.0, degree > 0 ? x[i] : 0.0, degree > 1 ? x[i] * x[i] : 0.0);
  };
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const Eigen::Vector3d powers = powers_at(i);
    products += weights[i] * powers * powers.transpose();
    right += weights[i] * values[i] * powers;
  }
  const Eigen::Vector3d solution = products.inverse() * right;
  double squares = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    squares += weights[i] * std::pow(values[i] - powers_at(i).dot(solution), 2);
  }
  return std::sqrt(squares / weights.sum());
}

class LineSpreadTest : public testing::InstructionSetTest {};

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, LineSpreadTest, testing::InstructionSets(), testing::InstructionSetName);

TEST_P(LineSpreadTest, IsWhatLeastSquaresSay) {
  for (const bool fades : {false, true}) {
    for (const int size : {3, 8, 15, 16, 17, 33, 100}) {
      // Along x, since y has no slope there.
      Offsets offsets = Arc(static_cast<size_t>(size), 0.0, 0.1, 0.05);
      Eigen::VectorXd x(size), y(size), z(size), weights(size);
      for (int i = 0; i < size; ++i) {
        const auto at = static_cast<size_t>(i);
        x[i] = 0.6 * double{offsets.neighbors.x[at]};
        y[i] = double{offsets.neighbors.y[at]};
        z[i] = double{offsets.neighbors.z[at]};
        // In a plane that is turned by a right angle, with half the radius.
        offsets.neighbors.x[at] = static_cast<float>(y[i] / 2.0);
        offsets.neighbors.y[at] = static_cast<float>(x[i] / 2.0);
        offsets.neighbors.z[at] = static_cast<float>(z[i] / 2.0);
        const double inner = fades ? std::max(1.0 - x[i] * x[i] - y[i] * y[i] - z[i] * z[i], 0.0) : 1.0;
        weights[i] = inner * inner;
      }
      for (auto* array : {&offsets.neighbors.x, &offsets.neighbors.y, &offsets.neighbors.z}) {
        std::fill_n(array->data() + size, NeighborOffsets::kPad, std::numeric_limits<float>::infinity());
      }
      const LineSpread spread = MeasureLine(offsets.neighbors, kUp, 0.5f, fades);

      // The widest direction, as eigenvectors have it.
      Eigen::Vector2d mean = Eigen::Vector2d::Zero();
      for (int i = 0; i < size; ++i) mean += weights[i] / weights.sum() * Eigen::Vector2d(x[i], y[i]);
      Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
      for (int i = 0; i < size; ++i) {
        const Eigen::Vector2d offset = Eigen::Vector2d(x[i], y[i]) - mean;
        covariance += weights[i] / weights.sum() * offset * offset.transpose();
      }
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance);
      Eigen::VectorXd along(size), across(size);
      for (int i = 0; i < size; ++i) {
        along[i] = axes.eigenvectors().col(1).dot(Eigen::Vector2d(x[i], y[i]));
        across[i] = axes.eigenvectors().col(0).dot(Eigen::Vector2d(x[i], y[i]));
      }
      const int degree = size < 16 ? 0 : 2;
      EXPECT_NEAR(spread.along, std::sqrt(axes.eigenvalues()[1]), 1e-6) << size;
      EXPECT_NEAR(spread.across, Rest(along, across, weights, degree), 1e-6) << size;
      EXPECT_NEAR(spread.thickness, Rest(along, z, weights, degree), 1e-6) << size;

      hwy::SetSupportedTargetsForTest(0);
      const LineSpread best = MeasureLine(offsets.neighbors, kUp, 0.5f, fades);
      hwy::SetSupportedTargetsForTest(GetParam());
      EXPECT_EQ(spread.along, best.along);
      EXPECT_EQ(spread.across, best.across);
      EXPECT_EQ(spread.thickness, best.thickness);
    }
  }
}

// The degree, at most the given one, that `lines` lines at distances of 1 / lines determine, with noise of so many of
// those in y and z.
int DegreeOf(int degree, int lines, double noise) {
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  double means[kMaxJetMoments] = {}, heights[kMaxJetSize] = {}, squared_heights = 0.0;
  constexpr int kPoints = 40;
  for (int line = 0; line < lines; ++line) {
    for (int i = 0; i < kPoints; ++i) {
      const double x = 2.0 * i / (kPoints - 1) - 1.0;
      const double y = (line - 0.5 * (lines - 1) + noise * normal(engine)) / lines, z = noise * normal(engine) / lines;
      for (int d = 0; d <= 2 * degree; ++d) {
        for (int b = 0; b <= d; ++b) {
          const double product = std::pow(x, d - b) * std::pow(y, b) / (lines * kPoints);
          means[JetIndex(d - b, b)] += product;
          if (d <= degree) heights[JetIndex(d - b, b)] += z * product;
        }
      }
      squared_heights += z * z / (lines * kPoints);
    }
  }
  return DeterminedDegree({degree, static_cast<size_t>(lines * kPoints), means, heights, squared_heights});
}

TEST(CurveDistanceTest, AsManyLinesFixNoPolynomialOfTheirDegree) {
  for (const double noise : {0.0, 0.004, 0.04}) {
    for (const int degree : {4, 6}) {
      for (int lines = 1; lines <= degree; ++lines) {
        EXPECT_EQ(DegreeOf(degree, lines, noise), lines - 1) << degree << " " << lines << " " << noise;
      }
      EXPECT_EQ(DegreeOf(degree, 15, noise), degree);
    }
  }
}

}  // namespace
}  // namespace curvd
