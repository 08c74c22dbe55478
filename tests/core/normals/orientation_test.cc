#include "core/normals/orientation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/core/instruction_sets.h"
#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

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

// Where they touch, one surface cannot be told from the other.
TEST(OrientationSidesTest, TouchingSpheresPointOutwardOrTheCertificateSaysNo) {
  TestPoints points = Sphere(20'000, 1.0), other = Sphere(20'000, 1.0);
  Shift(2.0, 0, 0, other);
  Append(other, points);
  const NormalResult result = OrientTurned(points);
  EXPECT_TRUE(FlippedShare(result.normals, points) < 0.001 || *result.report.certificate > kMaxTrustedCertificate);
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

TEST(OrientationSidesTest, TheCertificateSaysWhenSidesCannotBeTold) {
  constexpr size_t kPoints = 20'000;
  const double spacing = std::sqrt(8.0 / kPoints);
  const TestPoints thin = ClosedPlate(kPoints, spacing, 1), thick = ClosedPlate(kPoints, 12.0 * spacing, 1);
  const NormalResult wrong = MustMakeNormals(BareCloud(thin), EstimateBy(NormalMethod::kPca, 16));
  EXPECT_GT(FlippedShare(wrong.normals, thin), 0.02);
  EXPECT_GT(wrong.report.certificate.value_or(2.0), kMaxTrustedCertificate);
  const NormalResult right = MustMakeNormals(BareCloud(thick), EstimateBy(NormalMethod::kPca, 16));
  EXPECT_LT(FlippedShare(right.normals, thick), 0.005);
  EXPECT_LT(*right.report.certificate, kMaxTrustedCertificate);
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
  options.sides = SidesAlongDirection{{0, 0, -1e-9}};
  const NormalResult down = MustMakeNormals(BareCloud(sphere), options);
  for (size_t i = 0; i < sphere.size(); ++i) ASSERT_LE(down.normals[i].normal[2], 0.0f);
  EXPECT_EQ(down.report.piece_count, 0u);
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
