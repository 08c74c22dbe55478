#include "core/normals/orientation/orientation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/core/instruction_sets.h"
#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

// Sides of a quiet part that stay with other neighborhoods may be wrong in the same way.
TEST(NormalReportTest, WhatCancelsInPartsIsDoubtfulWhateverStays) {
  NormalReport report;
  report.max_trusted_certificate = 0.2;
  report.turned_share = 0.0;
  report.turned_share_decides = true;
  for (const auto& [certificate, is_doubtful] : {std::pair{0.1, false}, {0.4, false}, {0.6, true}, {2.0, true}}) {
    report.certificate = certificate;
    report.noisy_part.reset();
    EXPECT_FALSE(report.is_doubtful()) << certificate;
    report.noisy_part.emplace();
    EXPECT_EQ(report.is_doubtful(), is_doubtful) << certificate;
  }
}

NormalOptions Orient() {
  NormalOptions options;
  options.source = NormalSource::kOrient;
  return options;
}

// Orients the given normals after half of them, chosen at random, were turned.
NormalResult OrientTurned(TestPoints points, int threads = 2) {
  FlipAtRandom(0.5, 9, points);
  return MustMakeNormals(points.ToCloud(), Orient(), threads);
}

using OrientationTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, OrientationTest, InstructionSets(), InstructionSetName);

TEST_P(OrientationTest, ClosedSurfacesPointOutward) {
  for (const TestPoints& surface : {Sphere(3000, 2.0), Torus(3000, 1), Torus(30'000, 2)}) {
    const NormalResult result = OrientTurned(surface);
    EXPECT_EQ(FlippedShare(result.normals, surface), 0.0);
    EXPECT_EQ(result.report.piece_count, 1u);
    EXPECT_EQ(result.report.closed_piece_count, 1u);
    EXPECT_LT(*result.report.certificate, 0.1);
  }
}

TEST_P(OrientationTest, InstructionSetsGiveTheSameSides) {
  TestPoints torus = Torus(20'000, 3);
  AddNoise(0.1, 4, torus);
  const NormalResult here = OrientTurned(torus);
  hwy::SetSupportedTargetsForTest(0);
  EXPECT_TRUE(SameBytes(here.normals, OrientTurned(torus).normals));
}

TEST(OrientationSidesTest, EstimatedNormalsOfNoisySurfacesAgree) {
  TestPoints torus = Torus(50'000, 5);
  AddNoise(0.05, 6, torus);
  NormalOptions options;
  options.source = NormalSource::kEstimate;
  const NormalResult result = MustMakeNormals(BareCloud(torus), options);
  EXPECT_LT(FlippedShare(result.normals, torus), 1e-4);
  EXPECT_LT(*result.report.certificate, kMaxTrustedCertificate);
}

TEST(OrientationSidesTest, KnifeEdgesAreNoHindrance) {
  TestPoints lens = Sphere(20'000, 1.0);
  for (size_t i = 0; i < lens.size(); ++i) {
    auto& p = lens.positions[i];
    auto& n = lens.normals[i];
    p[2] *= 0.1f;
    n[2] *= 10.0f;
    const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (float& component : n) component /= length;
  }
  // At the rim itself, single points may lie on the wrong side.
  EXPECT_LT(FlippedShare(OrientTurned(lens).normals, lens), 0.001);
}

TEST(OrientationSidesTest, OpenSurfacesKeepTheSideOfTheMajority) {
  TestPoints waves = Waves(5000, 0.0, 1);
  for (size_t i = 0; i < waves.size(); ++i) {
    if (i % 3 == 0) continue;
    for (float& component : waves.normals[i]) component = -component;
  }
  const NormalResult result = MustMakeNormals(waves.ToCloud(), Orient());
  EXPECT_EQ(result.report.piece_count, 1u);
  EXPECT_EQ(result.report.closed_piece_count, 0u);
  EXPECT_FALSE(result.report.certificate.has_value());
  for (size_t i = 0; i < waves.size(); ++i) ASSERT_LT(result.normals[i].normal[2], 0.0f);
}

TEST(OrientationSidesTest, OpenSurfacesWithoutGivenNormalsPointUp) {
  const TestPoints waves = Waves(5000, 0.0, 1);
  const NormalResult result = MustMakeNormals(BareCloud(waves), EstimateBy(NormalMethod::kJet2, 20));
  EXPECT_EQ(FlippedShare(result.normals, waves), 0.0);
}

TEST(OrientationSidesTest, PiecesAreOrientedEachForItself) {
  TestPoints points = Sphere(500, 1.0);
  for (int i = 1; i < 9; ++i) {
    TestPoints more = Sphere(400 + 20 * static_cast<size_t>(i), 1.0);
    Shift(100.0 * i, 30.0 * (i % 3), 0, more);
    Append(more, points);
  }
  const NormalResult result = OrientTurned(points);
  EXPECT_EQ(result.report.piece_count, 9u);
  EXPECT_EQ(result.report.closed_piece_count, 9u);
  EXPECT_EQ(FlippedShare(result.normals, points), 0.0);
}

// Where they touch, links across are as cheap as those along, and estimated normals are of both.
TEST(OrientationSidesTest, TouchingSpheresPointOutward) {
  TestPoints points = Sphere(20'000, 1.0), other = Sphere(20'000, 1.0);
  Shift(2.0, 0, 0, other);
  Append(other, points);
  NormalOptions options;
  options.source = NormalSource::kEstimate;
  const NormalResult result = MustMakeNormals(BareCloud(points), options);
  EXPECT_LT(FlippedShare(result.normals, points), 0.01);
  EXPECT_FALSE(result.report.is_doubtful());
}

TEST(OrientationSidesTest, ConsistentCloudsStayAsTheyAre) {
  const TestPoints torus = Torus(10'000, 8);
  const NormalResult result = MustMakeNormals(torus.ToCloud(), Orient());
  EXPECT_EQ(result.report.flipped_count, 0u);
  const Cloud cloud = torus.ToCloud();
  for (size_t i = 0; i < torus.size(); ++i) ASSERT_EQ(result.normals[i].normal, cloud.normal(i));
}

TEST(OrientationSidesTest, PointsAtOnePlaceKeepTheSideOfTheMajority) {
  for (const bool first_of_three : {false, true}) {
    TestPoints points;
    for (int i = 0; i < 12; ++i) points.Add(1, 2, 3, 0, 0, (i % 3 == 0) == first_of_three ? -1.0 : 1.0);
    EXPECT_EQ(MustMakeNormals(points.ToCloud(), Orient()).report.flipped_count, 4u) << first_of_three;
  }
}

// At a thickness of one spacing, links across a plate are as cheap as those along it, and the tree turns half of it.
TEST(OrientationSidesTest, TheRepairSavesThinPlates) {
  constexpr size_t kPoints = 20'000;
  for (const double spacings : {1.0, 2.0, 4.0, 12.0}) {
    const TestPoints plate = ClosedPlate(kPoints, spacings * std::sqrt(8.0 / kPoints), 1);
    const NormalResult result = MustMakeNormals(BareCloud(plate), EstimateBy(NormalMethod::kPca, 12));
    EXPECT_LT(FlippedShare(result.normals, plate), 0.01) << spacings;
    EXPECT_LT(*result.report.certificate, kMaxTrustedCertificate) << spacings;
    EXPECT_FALSE(result.report.is_doubtful()) << spacings;
    EXPECT_EQ(result.report.repaired_count > 0, spacings == 1.0) << spacings;
  }
}

TEST(OrientationSidesTest, TheRepairSavesThinShells) {
  for (const double spacings : {4.0, 6.0}) {
    const TestPoints lens = Lens(20'000, spacings, 4);
    const NormalResult estimated = MustMakeNormals(BareCloud(lens), EstimateBy(NormalMethod::kPca, 12));
    EXPECT_LT(FlippedShare(estimated.normals, lens), 0.05) << spacings;
    EXPECT_GT(estimated.report.repaired_count, 0u) << spacings;
    EXPECT_EQ(FlippedShare(OrientTurned(lens).normals, lens), 0.0) << spacings;
  }
}

TEST(OrientationSidesTest, TheCertificateSaysWhenSidesCannotBeTold) {
  const TestPoints lens = Lens(20'000, 2.0, 4);
  const NormalResult wrong = MustMakeNormals(BareCloud(lens), EstimateBy(NormalMethod::kPca, 12));
  EXPECT_GT(FlippedShare(wrong.normals, lens), 0.02);
  EXPECT_TRUE(wrong.report.is_doubtful());
  // Joined where they touch, by a link that turns one of them.
  TestPoints touching = Sphere(20'000, 1.0), other = Sphere(20'000, 1.0);
  Shift(2.0, 0, 0, other);
  Append(other, touching);
  const NormalResult half = OrientTurned(touching);
  EXPECT_TRUE(FlippedShare(half.normals, touching) < 0.02 || half.report.is_doubtful());
}

TEST(OrientationSidesTest, NoisyOpenSheetsAreNotTurnedIntoClosedOnes) {
  for (const double sigma : {0.005, 0.02}) {
    TestPoints waves = Waves(20'000, 0.0, 1);
    AddNoise(sigma, 2, waves);
    NormalOptions options;
    options.source = NormalSource::kEstimate;
    const NormalResult result = MustMakeNormals(BareCloud(waves), options);
    EXPECT_LT(FlippedShare(result.normals, waves), 0.001) << sigma;
    EXPECT_EQ(result.report.repaired_count, 0u) << sigma;
    EXPECT_EQ(result.report.closed_piece_count, 0u) << sigma;
  }
}

TEST(OrientationSidesTest, PiecesThatAreSaidToBeClosedPointOutwardWhateverTheirHoles) {
  TestPoints bowl;
  const TestPoints sphere = Sphere(20'000, 1.0);
  for (size_t i = 0; i < sphere.size(); ++i) {
    const auto &p = sphere.positions[i], &n = sphere.normals[i];
    if (p[2] < 0.2f) bowl.Add(p[0], p[1], p[2], n[0], n[1], n[2]);
  }
  NormalOptions options = EstimateBy(NormalMethod::kJet2, 20);
  const NormalResult open = MustMakeNormals(BareCloud(bowl), options);
  EXPECT_EQ(FlippedShare(open.normals, bowl), 1.0);
  EXPECT_EQ(open.report.closed_piece_count, 0u);
  EXPECT_FALSE(open.report.certificate.has_value());
  options.sides = ConsistentSides{.closed = true};
  const NormalResult closed = MustMakeNormals(BareCloud(bowl), options);
  EXPECT_EQ(FlippedShare(closed.normals, bowl), 0.0);
  EXPECT_EQ(closed.report.closed_piece_count, 1u);
  EXPECT_LT(*closed.report.certificate, kMaxTrustedCertificate);
}

TEST(OrientationSidesTest, NestedPiecesPointOutwardEachForItself) {
  TestPoints points = Sphere(8000, 1.0);
  Append(Sphere(4000, 0.5), points);
  const NormalResult result = OrientTurned(points);
  EXPECT_EQ(FlippedShare(result.normals, points), 0.0);
  EXPECT_EQ(result.report.closed_piece_count, 2u);
  EXPECT_LT(*result.report.certificate, 0.05);
  // Nothing tells a ball within a ball from a hollow one.
  EXPECT_EQ(result.report.ambiguous_piece_count, 1u);
  EXPECT_TRUE(result.report.is_doubtful());
}

// What lies in a hollow is a body, as it should be.
TEST(OrientationSidesTest, BodiesWithinHollowsAreNoReasonForDoubt) {
  TestPoints points = Sphere(8000, 1.0);
  TestPoints inside = Sphere(5000, 0.8);
  for (auto& normal : inside.normals) {
    for (float& component : normal) component = -component;
  }
  Append(inside, points);
  Append(Sphere(1000, 0.3), points);
  const NormalResult result = OrientTurned(points);
  EXPECT_EQ(FlippedShare(result.normals, points), 0.0);
  EXPECT_EQ(result.report.inner_wall_count, 1u);
  EXPECT_EQ(result.report.ambiguous_piece_count, 0u);
  EXPECT_FALSE(result.report.is_doubtful());
}

// Such sides fit a closed surface in all but one thing: that it closes.
TEST(OrientationSidesTest, BowlsAreNotTurnedIntoClosedSurfaces) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    for (const size_t count : {500u, 1800u}) {
      const TestPoints sphere = RandomSphere(count, 1.0, seed);
      TestPoints bowl;
      for (size_t i = 0; i < sphere.size(); ++i) {
        const auto& p = sphere.positions[i];
        if (p[2] < 0.0f) bowl.Add(p[0], p[1], p[2], p[0], p[1], p[2]);
      }
      NormalOptions options;
      options.source = NormalSource::kEstimate;
      const NormalResult result = MustMakeNormals(BareCloud(bowl), options);
      const double flipped = FlippedShare(result.normals, bowl);
      if (std::min(flipped, 1.0 - flipped) > 0.02) {
        EXPECT_TRUE(result.report.is_doubtful()) << count << " " << seed;
      }
      EXPECT_EQ(result.report.repaired_count, 0u) << count << " " << seed;
    }
  }
}

// Of a hollow body's wall, the normals of the inside point into the hollow; what lies in a large hollow is a body.
TEST(OrientationSidesTest, InsidesOfHollowWallsPointIntoTheHollow) {
  for (const double inner : {0.85, 0.7}) {
    TestPoints shell = Sphere(8000, 1.0), inside = Sphere(static_cast<size_t>(8000 * inner * inner), inner),
               other = shell;
    for (auto& normal : inside.normals) {
      for (float& component : normal) component = -component;
    }
    Append(inside, shell);
    // Beside it, nothing changes.
    Shift(0, 2.5, 0, other);
    Append(other, shell);
    for (const NormalResult& result :
         {OrientTurned(shell), MustMakeNormals(BareCloud(shell), EstimateBy(NormalMethod::kJet2, 24))}) {
      EXPECT_LT(FlippedShare(result.normals, shell), 0.001) << inner;
      EXPECT_EQ(result.report.closed_piece_count, 3u) << inner;
      EXPECT_EQ(result.report.inner_wall_count, 1u) << inner;
      EXPECT_FALSE(result.report.is_doubtful()) << inner;
    }
  }
}

// Of shells within shells every other one bounds a hollow, however near the outermost is to the innermost.
TEST(OrientationSidesTest, ShellsWithinShellsBoundHollowsInTurn) {
  TestPoints shells;
  for (const double radius : {1.0, 0.87, 0.75, 0.62}) {
    TestPoints shell = Sphere(static_cast<size_t>(20'000 * radius * radius), radius);
    const bool bounds_a_hollow = radius == 0.87 || radius == 0.62;
    for (auto& normal : shell.normals) {
      for (float& component : normal) component *= bounds_a_hollow ? -1.0f : 1.0f;
    }
    Append(shell, shells);
  }
  const NormalResult result = OrientTurned(shells);
  EXPECT_EQ(result.report.piece_count, 4u);
  EXPECT_EQ(result.report.inner_wall_count, 2u);
  EXPECT_EQ(FlippedShare(result.normals, shells), 0.0);
}

TEST(OrientationSidesTest, ManyHollowBodiesAreLookedAtEachForItself) {
  TestPoints bodies;
  for (int i = 0; i < 20; ++i) {
    TestPoints outside = Sphere(1600, 1.0), inside = Sphere(800, 0.7);
    for (auto& normal : inside.normals) {
      for (float& component : normal) component = -component;
    }
    Append(inside, outside);
    Shift(3.0 * (i % 8), 3.0 * (i / 8), 0, outside);
    Append(outside, bodies);
  }
  const NormalResult result = OrientTurned(bodies);
  EXPECT_EQ(result.report.inner_wall_count, 20u);
  EXPECT_EQ(FlippedShare(result.normals, bodies), 0.0);
}

// A scene as a scanner sees it: ground, a wall and a ball, from one place, at distances that thin the points out.
TEST(OrientationSidesTest, AScannedSceneLooksAtItsScanner) {
  TestPoints scene;
  for (int row = -60; row < 90; ++row) {
    for (int column = 0; column < 400; ++column) {
      const double up = row * 0.01, around = column * 0.004 - 0.8;
      const double x = std::cos(up) * std::cos(around), y = std::cos(up) * std::sin(around), z = std::sin(up);
      // From the origin: the plane x = 10, and the ground z = -1.5, whichever comes first.
      const double wall = 10.0 / x, ground = z < 0.0 ? -1.5 / z : 1e9, range = std::min(wall, ground);
      if (range > 40.0) continue;
      ground < wall ? scene.Add(range * x, range * y, range * z, 0, 0, 1)
                    : scene.Add(range * x, range * y, range * z, -1, 0, 0);
    }
  }
  NormalOptions options = EstimateBy(NormalMethod::kJet2, 20);
  options.sides = SidesTowardViewpoint{{0, 0, 0}};
  const NormalResult result = MustMakeNormals(BareCloud(scene), options);
  EXPECT_LT(FlippedShare(result.normals, scene), 0.002);  // at the edge between the planes
  EXPECT_LT(MeanAngle(result.normals, scene), 1.0);
}

TEST(OrientationSidesTest, ViewpointsAndDirectionsDecideEachPoint) {
  const TestPoints sphere = Sphere(3000, 1.0);
  NormalOptions options = EstimateBy(NormalMethod::kJet2, 20);
  options.sides = SidesTowardViewpoint{{0, 0, 0}};
  EXPECT_EQ(FlippedShare(MustMakeNormals(BareCloud(sphere), options).normals, sphere), 1.0);
  std::vector<std::array<double, 3>> viewpoints;
  for (const auto& p : sphere.positions) viewpoints.push_back({2.0 * p[0], 2.0 * p[1], 2.0 * p[2]});
  options.sides = SidesTowardViewpoints{viewpoints};
  EXPECT_EQ(FlippedShare(MustMakeNormals(BareCloud(sphere), options).normals, sphere), 0.0);
  // Of any length: products with the shortest would be 0.
  for (const double length : {1e-9, 5e-324, 1e308}) {
    options.sides = SidesAlongDirection{{0, 0, -length}};
    const NormalResult down = MustMakeNormals(BareCloud(sphere), options);
    for (size_t i = 0; i < sphere.size(); ++i) ASSERT_LE(down.normals[i].normal[2], 0.0f) << length;
    EXPECT_EQ(down.report.piece_count, 0u);
  }
}

// Doubles are kept relative to an origin, and the index scales: a viewpoint is in the input's coordinates.
TEST(OrientationSidesTest, ViewpointsAreInTheCoordinatesOfTheInput) {
  const TestPoints sphere = Sphere(3000, 1.0);
  std::vector<double> far;
  for (const auto& p : sphere.positions) {
    far.insert(far.end(), {4e6 + 100.0 * p[0], 5e5 + 100.0 * p[1], 300 + 100.0 * p[2]});
  }
  Cloud cloud(ScalarType::kFloat64, InvalidPointPolicy::kReject, NormalsInput::kAbsent);
  ASSERT_TRUE(cloud.Append({reinterpret_cast<const char*>(far.data()), far.size() * sizeof(double)}, {}).ok());
  ASSERT_TRUE(cloud.Finish().ok());
  NormalOptions options = EstimateBy(NormalMethod::kJet2, 20);
  options.sides = SidesTowardViewpoint{{4e6, 5e5, 300}};
  EXPECT_EQ(FlippedShare(MustMakeNormals(std::move(cloud), options).normals, sphere), 1.0);
}

TEST(OrientationSidesTest, LayoutsOfAnyKindAreOriented) {
  for (const Layout layout : kLayouts) {
    const TestPoints points = RandomPoints(layout, 3000, 5);
    const NormalResult given = MustMakeNormals(points.ToCloud(), Orient());
    EXPECT_EQ(given.normals.size(), points.size()) << LayoutName(layout);
    EXPECT_GE(given.report.piece_count, 1u);
    NormalOptions options;
    options.source = NormalSource::kEstimate;
    MustMakeNormals(BareCloud(points), options);
  }
}

TEST(OrientationSidesTest, HostileCloudsEndWithStatuses) {
  constexpr size_t kPoints = 20'000;
  TestPoints equal, line, outlier = Sphere(kPoints, 1.0);
  for (size_t i = 0; i < kPoints; ++i) {
    equal.Add(1, 2, 3, 0, 0, 1);
    line.Add(0.001 * static_cast<double>(i), 0, 0, 0, 0, 1);
  }
  outlier.Add(1e30, 0, 0, 1, 0, 0);
  NormalOptions options;
  options.source = NormalSource::kEstimate;
  const auto count = [&](const TestPoints& points, PointStatus status) {
    return MustMakeNormals(BareCloud(points), options).report.status_counts[static_cast<size_t>(status)];
  };
  EXPECT_EQ(count(equal, PointStatus::kDegenerateArea), kPoints);
  EXPECT_EQ(count(line, PointStatus::kSingularFit), kPoints);
  EXPECT_EQ(count(outlier, PointStatus::kOk), kPoints);
  for (const TestPoints& points : {equal, line, outlier}) {
    EXPECT_EQ(MustMakeNormals(points.ToCloud(), Orient()).normals.size(), points.size());
  }
}

TEST(OrientationSidesTest, SmallCloudsAreOriented) {
  for (const size_t points : {size_t{0}, size_t{1}, size_t{2}, size_t{12}, size_t{13}, size_t{14}, size_t{65}}) {
    EXPECT_EQ(MustMakeNormals(Sphere(points, 1.0).ToCloud(), Orient()).normals.size(), points);
    NormalOptions options;
    options.source = NormalSource::kEstimate;
    EXPECT_EQ(MustMakeNormals(BareCloud(Sphere(points, 1.0)), options).normals.size(), points);
  }
}

}  // namespace
}  // namespace curvd::testing
