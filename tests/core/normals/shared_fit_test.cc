// Polynomials that the points of a leaf share, on each instruction set that this machine has.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/normals/normal_fit.h"
#include "tests/core/instruction_sets.h"
#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

using SharedFitTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, SharedFitTest, InstructionSets(), InstructionSetName);

NormalFit FitBy(NormalMethod method, uint32_t count, bool shares) {
  NormalFit fit;
  fit.method = method;
  fit.neighborhood = NeighborCount{count};
  fit.shares = shares;
  return fit;
}

// Of a sphere around the origin: the root mean square of the angles of the normals, in degrees.
double SphereError(const SpatialIndex& index, const PlacedNormals& made) {
  double squares = 0.0, count = 0.0;
  for (size_t place = 0; place < index.point_count(); ++place) {
    if (made.statuses[place] != PointStatus::kOk) continue;
    const SpatialIndex::LeafPositions& p = index.positions(place / SpatialIndex::kLeafSize);
    const size_t lane = place % SpatialIndex::kLeafSize;
    const auto& n = made.normals[place];
    const double length = std::hypot(p.x[lane], p.y[lane], p.z[lane]);
    const double dot = (p.x[lane] * n[0] + p.y[lane] * n[1] + p.z[lane] * n[2]) / length;
    const double angle = std::acos(std::min(std::abs(dot), 1.0)) * 180.0 / std::numbers::pi;
    squares += angle * angle;
    ++count;
  }
  return std::sqrt(squares / count);
}

SpatialIndex NoisySphere(double sigma) {
  TestPoints sphere = Sphere(20'000, 1.0);
  AddNoise(sigma, 1, sphere);
  return BuildIndex(sphere.ToCloud());
}

// Over an even disc of radius 1, the squared error of a slope by degree 2 at the distance t from the middle is 1 + 12
// t^2 times that in the middle. The 16 points of a square leaf have, of K neighbors, t^2 = pi 16 / 6 / K on
// average: 1.19 for 544, of which the root is 1.09; leaves twice as long as wide, 1.23 and 1.11. Noise of 0.8 spacings
// leaves nothing to bends.
TEST_P(SharedFitTest, NoiseMattersLittleMore) {
  SpatialIndex index = NoisySphere(0.02);
  const double own = SphereError(index, MakeByPlace(index, FitBy(NormalMethod::kJet2, 544, false)));
  const double shared = SphereError(index, MakeByPlace(index, FitBy(NormalMethod::kJet2, 544, true)));
  EXPECT_GT(shared, own);  // else nothing was shared
  EXPECT_LT(shared, 1.15 * own);
}

// Around the poles 384 neighbors lie on two lines, and noise decides a polynomial of degree 4.
TEST_P(SharedFitTest, ACloudOfLinesIsFittedWithoutNoise) {
  for (const bool crosses_lines : {false, true}) {
    const TestPoints ellipsoid = ScannedEllipsoid(0.0015, 1);
    SpatialIndex index = BuildIndex(ellipsoid.ToCloud());
    NormalFit fit = FitBy(NormalMethod::kJet4, 384, true);
    fit.crosses_lines = crosses_lines;
    const PlacedNormals made = MakeByPlace(index, fit);
    size_t far_off = 0;
    for (size_t place = 0; place < index.point_count(); ++place) {
      const int32_t id = index.positions(place / SpatialIndex::kLeafSize).id[place % SpatialIndex::kLeafSize];
      far_off += IsFarOff(made.normals[place], ellipsoid.normals[static_cast<size_t>(id)]) ? 1 : 0;
    }
    if (crosses_lines) {
      EXPECT_LE(far_off, ellipsoid.size() / 1000);
    } else {
      EXPECT_GE(far_off, ellipsoid.size() / 200);
    }
  }
}

// Without noise, the error is that of the bends, which polynomials follow wherever they are read.
TEST_P(SharedFitTest, BendsAreFollowed) {
  SpatialIndex index = BuildIndex(Sphere(20'000, 1.0).ToCloud());
  for (const NormalMethod method : {NormalMethod::kJet2, NormalMethod::kJet4}) {
    const double own = SphereError(index, MakeByPlace(index, FitBy(method, 272, false)));
    const double shared = SphereError(index, MakeByPlace(index, FitBy(method, 272, true)));
    // By degree 2, the third derivatives of a sphere vanish in the middle alone: at the distance r they turn the slope
    // by r^3 / 2 less what the fit follows, 0.06 degrees for the radius 0.12 of these neighborhoods.
    EXPECT_LT(shared, own + (method == NormalMethod::kJet2 ? 0.06 : 0.001)) << NormalMethodName(method);
  }
}

// Points of a leaf that are far from the others, or whose leaf has no fit, get what they would get alone.
TEST_P(SharedFitTest, PointsFarFromTheMeanAreFittedAlone) {
  TestPoints sheet = RandomPoints(Layout::kCoplanar, 5000, 7);
  for (int i = 0; i < 200; ++i) sheet.Add(0.5, 0.5, 9.0 + 1e-4 * i, 0, 0, 1);  // a line far away
  sheet.Add(0.5, 0.5, -9.0, 0, 0, 1);                                          // a point by itself
  SpatialIndex index = BuildIndex(sheet.ToCloud());
  const PlacedNormals own = MakeByPlace(index, FitBy(NormalMethod::kJet2, 64, false)),
                      shared = MakeByPlace(index, FitBy(NormalMethod::kJet2, 64, true));
  EXPECT_EQ(own.statuses, shared.statuses);
  size_t lines = 0, secluded = 0;
  for (const PointStatus status : shared.statuses) {
    lines += status == PointStatus::kSingularFit ? 1 : 0;
    secluded += status == PointStatus::kTooFewNeighbors ? 1 : 0;
  }
  EXPECT_EQ(lines, 200u);
  EXPECT_EQ(secluded, 1u);
}

// Where a run ends changes nothing, though it may be within a leaf.
TEST_P(SharedFitTest, RunsThatEndEarlyGoOn) {
  TestPoints scattered = RandomPoints(Layout::kAnisotropic, 3000, 3);
  SpatialIndex index = BuildIndex(scattered.ToCloud());
  const PlacedNormals whole = MakeByPlace(index, FitBy(NormalMethod::kJet2, 40, true));
  const PlacedNormals parts = MakeByPlace(index, FitBy(NormalMethod::kJet2, 40, true), 1);
  EXPECT_EQ(whole.statuses, parts.statuses);
  for (size_t place = 0; place < index.point_count(); ++place) {
    if (whole.statuses[place] != PointStatus::kOk) continue;
    for (size_t axis = 0; axis < 3; ++axis) {
      ASSERT_NEAR(whole.normals[place][axis], parts.normals[place][axis], 1e-6f) << place;
    }
  }
}

}  // namespace
}  // namespace curvd::testing
