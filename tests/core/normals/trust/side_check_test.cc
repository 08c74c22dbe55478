#include "core/normals/trust/side_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

NormalOptions AutomaticNormals() {
  NormalOptions options;
  options.source = NormalSource::kEstimate;
  return options;
}

TestPoints TorusWithNoise(size_t points, double spacings) {
  TestPoints torus = Torus(points, 1);
  AddNoise(spacings * std::sqrt(48.0 * std::numbers::pi * std::numbers::pi / static_cast<double>(points)), 2, torus);
  return torus;
}

// Their certificates are what noise makes of right normals, too.
TEST(SideCheckTest, SmallNoisyCloudsAreTrustedOnlyIfAnotherScaleAgrees) {
  size_t wrong = 0;
  for (const size_t points : {300u, 1000u}) {
    for (const double noise : {0.7, 1.0, 1.5}) {
      const TestPoints torus = TorusWithNoise(points, noise);
      const NormalResult result = MustMakeNormals(BareCloud(torus), AutomaticNormals());
      const bool is_wrong = FlippedShare(result.normals, torus) > 0.02;
      wrong += is_wrong ? 1 : 0;
      EXPECT_TRUE(!is_wrong || result.report.is_doubtful()) << points << " " << noise;
    }
  }
  EXPECT_GE(wrong, 3u);
}

// Closed surfaces can be fitted to the noise of an open sheet.
TEST(SideCheckTest, NoisyOpenSheetsAreTrusted) {
  TestPoints waves = Waves(5000, 0.0, 1);
  AddNoise(0.03, 2, waves);
  const NormalResult result = MustMakeNormals(BareCloud(waves), AutomaticNormals());
  const double flipped = FlippedShare(result.normals, waves);
  EXPECT_LT(std::min(flipped, 1.0 - flipped), 0.005);
  ASSERT_TRUE(result.report.turned_share.has_value());
  EXPECT_LT(*result.report.turned_share, kMostTurnedShare);
  EXPECT_FALSE(result.report.is_doubtful());
}

// What is handed out are the normals of the scale that was chosen, as if no other had been tried.
TEST(SideCheckTest, TheOtherScaleLeavesNoTrace) {
  const TestPoints torus = TorusWithNoise(5000, 0.3);
  const NormalResult result = MustMakeNormals(BareCloud(torus), AutomaticNormals());
  ASSERT_TRUE(result.report.turned_share.has_value());
  const NormalResult fixed =
      MustMakeNormals(BareCloud(torus), EstimateBy(*result.report.method, result.report.neighbor_count));
  EXPECT_FALSE(fixed.report.turned_share.has_value());
  EXPECT_TRUE(SameBytes(result.normals, fixed.normals));
  EXPECT_EQ(result.report.status_counts, fixed.report.status_counts);
}

// The narrow sides of a plate that is one spacing thick have no normals of their own in any fit to both sheets.
TEST(RimTest, ThinPlatesHaveTheRightSidesUpToTheirRims) {
  constexpr size_t kPoints = 5000;
  for (const double spacings : {0.7, 1.0, 1.5}) {
    const TestPoints plate = ClosedPlate(kPoints, spacings * std::sqrt(8.0 / kPoints), 3);
    const NormalResult result = MustMakeNormals(BareCloud(plate), AutomaticNormals());
    EXPECT_LT(FlippedShare(result.normals, plate), 0.005) << spacings;
    EXPECT_FALSE(result.report.is_doubtful()) << spacings;
  }
}

}  // namespace
}  // namespace curvd::testing
