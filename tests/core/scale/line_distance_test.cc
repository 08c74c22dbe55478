#include "core/scale/line_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
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

// In the plane of x and y.
PointLine LineIn(PilotNeighbors& neighbors) { return LineOf(neighbors.scratch(), {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}); }

// Points of lines along x that lie `gap` apart, moved along them by `shift` times their distance of 1, and across the
// lines and away from the plane by `noise` times it.
double DistanceOfLines(double gap, double shift, double noise = 0.0, uint64_t seed = 5) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> gaussian(0.0, 1.0);
  PilotNeighbors neighbors;
  for (int line = -5; line <= 5; ++line) {
    for (int i = -20; i <= 20; ++i) {
      const bool is_own = line == 0 && i == 0;
      const auto off = [&](double by) { return is_own ? 0.0 : by * gaussian(random); };
      const double x = i + off(shift), y = line * gap + off(noise), z = off(noise);
      neighbors.Add(x, y, z);
    }
  }
  return LineIn(neighbors).distance;
}

TEST(LineDistanceTest, LinesAreAsFarAsTheNextOne) {
  EXPECT_NEAR(DistanceOfLines(3.0, 0.0), 3.0, 1e-5);
  EXPECT_NEAR(DistanceOfLines(5.0, 0.1), 5.0, 0.2);
  EXPECT_NEAR(DistanceOfLines(10.0, 0.1), 10.0, 0.2);
}

TEST(LineDistanceTest, NoiseHidesFewLines) {
  for (const double gap : {5.0, 10.0}) {
    int found = 0;
    for (uint64_t seed = 0; seed < 100; ++seed) {
      found += std::abs(DistanceOfLines(gap, 0.1, 0.3, seed) - gap) < 0.2 * gap ? 1 : 0;
    }
    EXPECT_GE(found, 90) << gap;
  }
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
    on_lines += LineIn(neighbors).distance > 0.0 ? 1 : 0;
  }
  EXPECT_LE(on_lines, 10u);
}

TEST(LineDistanceTest, OneLineAloneHasNoNext) {
  PilotNeighbors neighbors;
  for (int i = -20; i <= 20; ++i) neighbors.Add(i, 0.0, 0.0);
  EXPECT_EQ(LineIn(neighbors).distance, 0.0);
  neighbors.Add(0.0, 10.0, 0.0);
  const PointLine line = LineIn(neighbors);
  EXPECT_NEAR(line.distance, 10.0, 1e-5);
  EXPECT_NEAR(std::abs(line.direction[0]), 1.0, 1e-6);
}

// Points on lines along x, 5 apart, whose estimates of less than 45 neighbors show `small`, with this share of it along
// the lines, and of 45 neighbors 0, to which each larger number adds `change`.
PilotTable TableOnLines(float small, float along_lines, float change = 0.0f) {
  constexpr size_t kFirstLarge = 3;
  static_assert(kScaleRungs[kFirstLarge] == 45);
  PilotTable table;
  for (int i = 0; i < 100; ++i) {
    PilotPoint point({static_cast<float>(i), 0.0f, 0.0f});
    point.line_distance = 5.0f;
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      point.radius[rung] = std::sqrt(static_cast<float>(kScaleRungs[rung]) * 5.0f / 3.14f);
      for (size_t method = 0; method < kMethodCount; ++method) {
        const bool is_small = rung < kFirstLarge;
        point.mean[method][rung].fill(is_small ? small : change * static_cast<float>(rung - kFirstLarge));
        point.difference[method][rung].fill(is_small ? (along_lines - 1.0f) * small : 0.0f);
        point.twist[method][rung].fill(0.0f);
      }
    }
    table.push_back(point);
  }
  return table;
}

// How many neighbors the first estimate of the method has.
uint32_t FirstCount(const PilotPoint& point, size_t method) {
  size_t rung = 0;
  while (rung < kRungCount && std::isnan(point.mean[method][rung][PilotPoint::kAll])) ++rung;
  return rung < kRungCount ? kScaleRungs[rung] : 0;
}

TEST(DropUndeterminedAcrossLinesTest, HigherDegreesNeedMoreLines) {
  PilotTable table = TableOnLines(0.1f, 0.0f);
  DropUndeterminedAcrossLines({}, table);
  EXPECT_EQ(FirstCount(table[7], kHexagramMethod), 16u);
  EXPECT_EQ(FirstCount(table[7], kQuadraticRegressionMethod), 45u);
  EXPECT_EQ(FirstCount(table[7], kRegressionMethod), 64u);
  EXPECT_EQ(FirstCount(table[7], kQuarticMethod), 128u);
  EXPECT_EQ(FirstCount(table[7], kSexticMethod), 256u);
}

TEST(DropUndeterminedAcrossLinesTest, DetailAlongLinesKeepsSmallNeighborhoods) {
  PilotTable table = TableOnLines(0.1f, 2.0f);
  DropUndeterminedAcrossLines({}, table);
  EXPECT_EQ(FirstCount(table[7], kSexticMethod), 16u);
}

// Whatever tells them, they fit what larger ones show.
TEST(DropUndeterminedAcrossLinesTest, WhatDiffersLittleStays) {
  PilotTable alike = TableOnLines(0.1f, 0.0f, 0.03f), unlike = TableOnLines(0.1f, 0.0f, 0.01f);
  DropUndeterminedAcrossLines({}, alike);
  EXPECT_EQ(FirstCount(alike[7], kRegressionMethod), 16u);
  DropUndeterminedAcrossLines({}, unlike);
  EXPECT_EQ(FirstCount(unlike[7], kRegressionMethod), 64u);
}

// What is told at all of them would be too large for most.
TEST(DropUndeterminedAcrossLinesTest, AFewPointsBetweenWiderLinesDoNotCount) {
  for (const size_t wider : {size_t{20}, size_t{40}}) {
    PilotTable table = TableOnLines(0.1f, 0.0f);
    for (size_t i = 0; i < wider; ++i) table[i].line_distance = 20.0f;
    DropUndeterminedAcrossLines({}, table);
    EXPECT_EQ(FirstCount(table[80], kRegressionMethod), wider == 20 ? 64u : 1024u);
  }
}

TEST(DropUndeterminedAcrossLinesTest, ResidualsOfUndeterminedFitsAreNotNoise) {
  PilotTable table = TableOnLines(0.1f, 0.0f);
  for (PilotPoint& point : table) point.residual.fill(0.01f);
  DropUndeterminedAcrossLines({}, table);
  EXPECT_TRUE(std::isnan(table[7].residual[5]));
  EXPECT_EQ(table[7].residual[6], 0.01f);
}

TEST(DropUndeterminedAcrossLinesTest, SoDoPointsThatMostlyLieOnNone) {
  PilotTable table = TableOnLines(0.1f, 0.0f);
  for (size_t i = 0; i < 60; ++i) table[i].line_distance = 0.0f;
  DropUndeterminedAcrossLines({}, table);
  EXPECT_EQ(FirstCount(table[80], kSexticMethod), 16u);
}

TEST(DropUndeterminedAcrossLinesTest, NothingIsPreferredWhereNoNeighborhoodCrossesEnough) {
  PilotTable table = TableOnLines(0.1f, 0.0f);
  for (PilotPoint& point : table) point.line_distance = 100.0f;
  DropUndeterminedAcrossLines({}, table);
  EXPECT_EQ(FirstCount(table[7], kSexticMethod), 16u);
}

TEST(DropUndeterminedAcrossLinesTest, WhatTheBoundsLeaveIsBetterThanNothing) {
  ScaleBounds few, jets;
  few.most_count = 32;
  few.methods = jets.methods = {};
  few.methods[kRegressionMethod] = jets.methods[kQuarticMethod] = true;
  jets.most_count = 91;
  for (const ScaleBounds& bounds : {few, jets}) {
    PilotTable table = TableOnLines(0.1f, 0.0f);
    DropUndeterminedAcrossLines(bounds, table);
    EXPECT_EQ(FirstCount(table[7], kRegressionMethod), 16u);
  }
  jets.most_count = 128;
  PilotTable table = TableOnLines(0.1f, 0.0f);
  DropUndeterminedAcrossLines(jets, table);
  EXPECT_EQ(FirstCount(table[7], kQuarticMethod), 128u);
}

}  // namespace
}  // namespace curvd::testing
