#include "core/normals/sheet_probe.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

constexpr size_t kManyPoints = 20'000;

NormalOptions AutomaticNormals() {
  NormalOptions options;
  options.source = NormalSource::kEstimate;
  return options;
}

TestPoints Plate(double spacings) { return ClosedPlate(kManyPoints, spacings * std::sqrt(8.0 / kManyPoints), 1); }

// Taken as noise, the thickness would make normals of hundreds of neighbors, from both sheets.
TEST(SheetProbeTest, ThinPlatesGetNormalsOfOneSheet) {
  for (const double spacings : {1.0, 2.0, 3.0}) {
    const TestPoints plate = Plate(spacings);
    const NormalResult result = MustMakeNormals(BareCloud(plate), AutomaticNormals());
    EXPECT_LE(result.report.neighbor_count, 34u) << spacings;
    EXPECT_LT(FlippedShare(result.normals, plate), spacings == 1.0 ? 0.01 : 0.001) << spacings;
    EXPECT_FALSE(result.report.is_doubtful()) << spacings;
  }
}

TEST(SheetProbeTest, NoiseDoesNotHideThinPlates) {
  TestPoints plate = Plate(3.0);
  AddNoise(0.3 * std::sqrt(8.0 / kManyPoints), 2, plate);
  const NormalResult result = MustMakeNormals(BareCloud(plate), AutomaticNormals());
  EXPECT_LT(FlippedShare(result.normals, plate), 0.005);
  EXPECT_FALSE(result.report.is_doubtful());
}

TEST(SheetProbeTest, ShellsOfAFewSpacingsAreMostlyRight) {
  for (const double spacings : {4.0, 6.0}) {
    const TestPoints shell = Lens(kManyPoints, spacings, 4);
    const NormalResult result = MustMakeNormals(BareCloud(shell), AutomaticNormals());
    EXPECT_LT(FlippedShare(result.normals, shell), 0.05) << spacings;
  }
}

// Whatever cannot be told apart is at least said to be doubtful, whoever chose the scale.
TEST(SheetProbeTest, FlippedPointsAreNeverTrusted) {
  for (const double spacings : {0.5, 1.0, 1.5, 2.0, 3.0, 8.0}) {
    const TestPoints shell = Lens(kManyPoints, spacings, 4);
    for (const NormalOptions& options :
         {AutomaticNormals(), EstimateBy(NormalMethod::kPca, 12), EstimateBy(NormalMethod::kJet2, 48)}) {
      const NormalResult result = MustMakeNormals(BareCloud(shell), options);
      EXPECT_TRUE(FlippedShare(result.normals, shell) <= 0.02 || result.report.is_doubtful())
          << spacings << " " << result.report.neighbor_count << ": " << FlippedShare(result.normals, shell) << " "
          << result.report.certificate.value_or(-1);
    }
  }
}

TEST(SheetProbeTest, NoiseIsNotTakenForTwoSheets) {
  for (const double sigma : {0.0, 0.05, 0.1, 0.2}) {
    TestPoints torus = Torus(kManyPoints, 1);
    AddNoise(sigma, 2, torus);
    const NormalResult result = MustMakeNormals(BareCloud(torus), AutomaticNormals());
    EXPECT_TRUE(sigma == 0.0 || result.report.neighbor_count >= 48) << sigma;
    EXPECT_LT(FlippedShare(result.normals, torus), 0.001) << sigma;
    EXPECT_FALSE(result.report.is_doubtful()) << sigma << " " << *result.report.certificate;
  }
}

SheetFinding FindingOf(const TestPoints& points) {
  const SpatialIndex index = BuildIndex(points.ToCloud());
  SheetProbe probe(index, 10'000, 1);
  const std::atomic<bool> stopped = false;
  for (size_t block = 0; block < probe.block_count(); ++block) {
    EXPECT_TRUE(probe.RunBlock(block, 0, stopped).ok());
  }
  return probe.Find();
}

// Noise is normal, two sheets are not, and bends of one sheet are small.
TEST(SheetProbeTest, WhatIsUnlikeNoiseMayBeTwoSheets) {
  constexpr size_t kPoints = 5000;
  EXPECT_TRUE(FindingOf(ClosedPlate(kPoints, 0.7 * std::sqrt(8.0 / kPoints), 1)).unlike_noise);
  EXPECT_TRUE(FindingOf(ClosedPlate(kPoints, 1.5 * std::sqrt(8.0 / kPoints), 1)).unlike_noise);
  for (const double sigma : {0.0, 0.1, 0.3}) {
    TestPoints torus = Torus(kPoints, 1);
    AddNoise(sigma, 2, torus);
    EXPECT_FALSE(FindingOf(torus).unlike_noise) << sigma;
  }
}

}  // namespace
}  // namespace curvd::testing
