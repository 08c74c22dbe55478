#include "core/scale/line_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>

namespace curvd::testing {
namespace {

// Neighbors of the origin, which must be among them.
class PilotNeighbors {
 public:
  void Add(double x, double y, double z) {
    NeighborArrays& n = scratch_.neighbors;
    n.Reserve(n.count + 1);
    scratch_.ids.Reserve(n.count + 1);
    n.dx[n.count] = static_cast<float>(x);
    n.dy[n.count] = static_cast<float>(y);
    n.dz[n.count] = static_cast<float>(z);
    scratch_.ids[n.count] = static_cast<int32_t>(n.count);
    scratch_.squared.push_back(static_cast<float>(x * x + y * y + z * z));
    ++n.count;
  }

  const PilotScratch& scratch() {
    scratch_.order.resize(scratch_.neighbors.count);
    std::iota(scratch_.order.begin(), scratch_.order.end(), 0U);
    std::sort(scratch_.order.begin(), scratch_.order.end(),
              [this](uint32_t a, uint32_t b) { return scratch_.squared[a] < scratch_.squared[b]; });
    return scratch_;
  }

 private:
  PilotScratch scratch_;
};

constexpr double kFar = 100.0;

// Points of lines along x that lie `gap` apart, moved along them by `shift` times their distance of 1.
double DistanceOfLines(double gap, double shift) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> gaussian(0.0, 1.0);
  PilotNeighbors neighbors;
  for (int line = -5; line <= 5; ++line) {
    for (int i = -20; i <= 20; ++i) {
      const bool is_own = line == 0 && i == 0;
      neighbors.Add(i + (is_own ? 0.0 : shift * gaussian(random)), line * gap, 0.0);
    }
  }
  return LineDistance(kFar, neighbors.scratch());
}

TEST(LineDistanceTest, LinesAreAsFarAsTheNextOne) {
  EXPECT_NEAR(DistanceOfLines(3.0, 0.0), 3.0, 1e-5);
  EXPECT_NEAR(DistanceOfLines(5.0, 0.1), 5.0, 0.2);
  EXPECT_NEAR(DistanceOfLines(10.0, 0.1), 10.0, 0.2);
}

TEST(LineDistanceTest, EvenAndRandomPointsLieOnNone) {
  EXPECT_EQ(DistanceOfLines(1.0, 0.0), 0.0);
  EXPECT_EQ(DistanceOfLines(1.5, 0.0), 0.0);
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  size_t on_lines = 0;
  for (int cloud = 0; cloud < 500; ++cloud) {
    PilotNeighbors neighbors;
    neighbors.Add(0.0, 0.0, 0.0);
    for (int i = 0; i < 100; ++i) neighbors.Add(coordinate(random), coordinate(random), 0.0);
    on_lines += LineDistance(kFar, neighbors.scratch()) > 0.0 ? 1 : 0;
  }
  EXPECT_LE(on_lines, 5u);
}

TEST(LineDistanceTest, NothingIsSaidWhereNoNeighborhoodCrossesEnough) {
  PilotNeighbors neighbors;
  for (int i = -20; i <= 20; ++i) neighbors.Add(i, 0.0, 0.0);
  EXPECT_EQ(LineDistance(kFar, neighbors.scratch()), 0.0) << "one line alone";
  neighbors.Add(0.0, 10.0, 0.0);
  EXPECT_NEAR(LineDistance(kFar, neighbors.scratch()), 10.0, 1e-5);
  EXPECT_EQ(LineDistance(20.0, neighbors.scratch()), 0.0);
}

TEST(LineDistanceTest, HigherDegreesNeedMoreLines) {
  EXPECT_LT(LeastRadiusOverLines(kLinearRegressionMethod), LeastRadiusOverLines(kQuadraticRegressionMethod));
  EXPECT_LT(LeastRadiusOverLines(kQuadraticRegressionMethod), LeastRadiusOverLines(kRegressionMethod));
  EXPECT_LT(LeastRadiusOverLines(kQuarticMethod), LeastRadiusOverLines(kSexticMethod));
}

}  // namespace
}  // namespace curvd::testing
