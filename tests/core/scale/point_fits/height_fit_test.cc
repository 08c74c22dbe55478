#include "core/scale/point_fits/height_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace curvd::testing {
namespace {

constexpr uint32_t kLeastCount = 16;

// The fit of the height over the plane of x and y, of neighbors that come in the order of their distance.
std::optional<PointFit> FitOf(const std::vector<Eigen::Vector3d>& offsets, double noise = 0.0) {
  std::vector<NeighborNormal> neighbors;
  for (const Eigen::Vector3d& offset : offsets) neighbors.push_back({offset, Eigen::Vector3d::UnitZ()});
  std::vector<const NeighborNormal*> nearest;
  for (const NeighborNormal& neighbor : neighbors) nearest.push_back(&neighbor);
  return EstimateByHeights(NormalFrame(Eigen::Vector3d::UnitZ()), nearest, kLeastCount, noise);
}

// Of the paraboloid with H = -1 at the origin, over a spiral of 64 points that fills the disc of radius 0.1, or the
// part of it where x is positive.
std::vector<Eigen::Vector3d> Paraboloid(bool is_half) {
  std::vector<Eigen::Vector3d> offsets;
  for (int i = 0; offsets.size() < 64; ++i) {
    const double r = 0.1 * std::sqrt((i + 0.5) / (is_half ? 128.0 : 64.0)), turn = 2.4 * i;
    const double x = r * std::cos(turn), y = r * std::sin(turn);
    if (!is_half || x > 0.0) offsets.emplace_back(x, y, 0.5 * (x * x + y * y));
  }
  return offsets;
}

TEST(HeightFitTest, DiscsAndBordersTell) {
  for (const bool is_half : {false, true}) {
    const auto fit = FitOf(Paraboloid(is_half));
    ASSERT_TRUE(fit.has_value()) << is_half;
    EXPECT_NEAR(fit->point.mean, -1.0, 0.01) << is_half;
  }
}

// A line that bends within the plane is nearly a conic: polynomials of degree 2 pass through it and do what they like
// beside it.
TEST(HeightFitTest, NeighborsOnOneLineTellNothing) {
  std::vector<Eigen::Vector3d> offsets;
  for (int i = 0; i < 64; ++i) {
    const double x = 0.003 * ((i + 1) / 2) * (i % 2 == 0 ? 1.0 : -1.0), y = x * x * (1.0 + x);
    offsets.emplace_back(x, y, 0.5 * (x * x + y * y));
  }
  EXPECT_FALSE(FitOf(offsets).has_value());
}

// A polynomial of degree 2 goes through three lines whatever their heights are, as where each was rounded to another
// multiple of a quantum.
TEST(HeightFitTest, ThreeLinesTellNothing) {
  for (const int lines : {3, 7}) {
    std::vector<Eigen::Vector3d> offsets;
    for (int line = -lines / 2; line <= lines / 2; ++line) {
      for (int i = -20; i <= 20; ++i) {
        const double x = 0.02 * line, y = 0.003 * i;
        offsets.emplace_back(x, y, line == 0 ? 0.0 : 0.5 * (x * x + y * y));
      }
    }
    std::sort(offsets.begin(), offsets.end(), [](const auto& a, const auto& b) { return a.norm() < b.norm(); });
    offsets.resize(lines == 3 ? 64 : 256);
    EXPECT_EQ(FitOf(offsets).has_value(), lines == 7) << lines;
  }
}

// Beside the top of a rounded crease, two spacings in radius, between two planes: many neighbors agree about what the
// crease is from afar.
TEST(HeightFitTest, IntervalsOfFewNeighborsBoundWhatManySay) {
  constexpr double kRadius = 0.02, kFromTop = 0.004;
  const double distance = std::hypot(kFromTop, kRadius), slope = -kFromTop / distance;
  std::vector<Eigen::Vector3d> offsets;
  for (int i = 0; i < 256; ++i) {
    const double r = 0.1 * std::sqrt((i + 0.5) / 256.0), turn = 2.4 * i, x = r * std::cos(turn);
    offsets.emplace_back(x, r * std::sin(turn), std::hypot(x - kFromTop, kRadius) - distance - slope * x);
  }
  const auto fit = FitOf(offsets);
  ASSERT_TRUE(fit.has_value());
  // 256 neighbors leave the least, and are off by 15.
  const double truth = -0.5 * kRadius * kRadius / (distance * distance * distance);
  EXPECT_NEAR(fit->point.mean, truth, 5.0);
}

// What happens to be exact may err as much as others do.
TEST(HeightFitTest, ErrorsAreThoseOfTheNoiseAtLeast) {
  const auto exact = FitOf(Paraboloid(false)), noisy = FitOf(Paraboloid(false), 1e-4);
  ASSERT_TRUE(exact.has_value() && noisy.has_value());
  EXPECT_LT(exact->mean_error, 1e-6);
  EXPECT_GT(noisy->mean_error, 3.0 * 1e-4 / (0.1 * 0.1));
}

}  // namespace
}  // namespace curvd::testing
