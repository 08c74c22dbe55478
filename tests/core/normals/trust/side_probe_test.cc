#include "core/normals/trust/side_probe.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>

#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

NormalOptions AutomaticNormals() {
  NormalOptions options;
  options.source = NormalSource::kEstimate;
  return options;
}

// Of 900 points or so, as thick as 3 of their spacings.
TestPoints SmallPlate(uint64_t seed) { return ClosedPlate(900, 3.0 * std::sqrt(8.0 / 900.0), seed); }

// Taken for noise, their thickness would ask for so many neighbors that those of both sheets are fitted at once; their
// certificate is low all the same.
TEST(SideProbeTest, SmallThinPlatesGetNormalsOfOneSheet) {
  for (const uint64_t seed : {1, 2, 3}) {
    const TestPoints plate = SmallPlate(seed);
    const NormalResult result = MustMakeNormals(BareCloud(plate), AutomaticNormals());
    EXPECT_LT(FlippedShare(result.normals, plate), 0.005);
    EXPECT_FALSE(result.report.mixes_sides);
    EXPECT_FALSE(result.report.is_doubtful());
  }
}

TEST(SideProbeTest, NormalsOfBothSheetsAreDoubtful) {
  const TestPoints plate = SmallPlate(1);
  const NormalResult result = MustMakeNormals(BareCloud(plate), EstimateBy(NormalMethod::kJet2, 272));
  EXPECT_GT(FlippedShare(result.normals, plate), 0.02);
  ASSERT_TRUE(result.report.opposed_share.has_value());
  EXPECT_GT(*result.report.opposed_share, 0.4);
  EXPECT_TRUE(result.report.mixes_sides);
  EXPECT_TRUE(result.report.is_doubtful());
}

// Half of the rims of thin lenses came out wrong, made as those of one sheet.
TEST(SideProbeTest, ThinLensesHaveTheRightSidesUpToTheirRims) {
  for (const size_t points : {900u, 5000u}) {
    for (const double spacings : {2.0, 3.0, 4.0}) {
      const TestPoints lens = Lens(points, spacings, 4);
      const NormalResult result = MustMakeNormals(BareCloud(lens), AutomaticNormals());
      EXPECT_LT(FlippedShare(result.normals, lens), 0.02) << points << " " << spacings;
    }
  }
}

TEST(SideProbeTest, OneSheetHasNeighborsOfItsSide) {
  TestPoints torus = Torus(10'000, 1);
  for (const double noise : {0.0, 0.1}) {
    if (noise > 0.0) AddNoise(noise, 2, torus);
    const NormalResult result = MustMakeNormals(BareCloud(torus), AutomaticNormals());
    ASSERT_TRUE(result.report.opposed_share.has_value());
    EXPECT_LT(*result.report.opposed_share, 0.01) << noise;
    ASSERT_TRUE(result.report.torn_share.has_value());
    EXPECT_LT(*result.report.torn_share, 0.0001) << noise;
    EXPECT_FALSE(result.report.is_doubtful()) << noise;
  }
}

struct Shares {
  double opposed, torn;
};

NormalFit FitTo(uint32_t count) {
  NormalFit fit;
  fit.neighborhood = NeighborCount{count};
  return fit;
}

Shares SharesOf(const TestPoints& points, const NormalFit& fit) {
  const SpatialIndex index = BuildIndex(points.ToCloud());
  SideProbe probe(index, fit, 1);
  const std::atomic<bool> stopped = false;
  for (size_t block = 0; block < probe.block_count(); ++block) {
    EXPECT_TRUE(probe.RunBlock(block, 0, stopped).ok());
  }
  return {probe.OpposedShare(), probe.TornShare()};
}

Shares SharesOf(const TestPoints& points, uint32_t count) { return SharesOf(points, FitTo(count)); }

// Its winding number hardly tells.
TEST(SideProbeTest, ATurnedPatchOfABallTears) {
  TestPoints ball = Sphere(2000, 1.0);
  EXPECT_EQ(SharesOf(ball, 24).torn, 0.0);
  EXPECT_LT(SharesOf(ball, 24).opposed, 1e-3);
  for (size_t i = 0; i < ball.size(); ++i) {
    if (ball.positions[i][2] < 0.74f) continue;  // 13 %
    for (float& component : ball.normals[i]) component = -component;
  }
  EXPECT_GT(SharesOf(ball, 24).torn, 2.0 * kMostTornShare);
}

// Neighbors across a plate are none along one sheet, however thin it is.
TEST(SideProbeTest, TheOtherSheetIsNoTear) {
  for (const double spacings : {0.7, 1.0, 2.0}) {
    const TestPoints plate = ClosedPlate(5000, spacings * std::sqrt(8.0 / 5000.0), 1);
    EXPECT_LT(SharesOf(plate, 24).torn, 0.001) << spacings;
    EXPECT_GT(SharesOf(plate, 200).opposed, 0.4) << spacings;
  }
}

// Few neighbors are of one sheet, but many are not.
TEST(SideProbeTest, NoisyPartsHaveTheirOwnNeighborhoods) {
  const TestPoints plate = ClosedPlate(5000, 4.0 * std::sqrt(8.0 / 5000.0), 1);
  NormalFit fit = FitTo(12);
  fit.noisy_part = NoisyPart{.neighborhood = NeighborCount{400}, .probe_count = 12, .least_variance = 1e30};
  EXPECT_LT(SharesOf(plate, fit).opposed, 0.01);
  fit.noisy_part->least_variance = 0.0;
  EXPECT_GT(SharesOf(plate, fit).opposed, 0.3);
}

// A noisy cap of a ball, of which a part is turned, beside a quiet rest that has most of the points, and no torn pair.
TEST(SideProbeTest, ASmallNoisyPartThatIsTornCounts) {
  TestPoints ball = Sphere(20'000, 1.0);
  const auto is_noisy = [&](size_t i) { return ball.positions[i][2] > 0.85f; };
  for (size_t i = 0; i < ball.size(); ++i) {
    const bool is_turned = is_noisy(i) && ball.positions[i][0] > 0.2f;
    for (float& component : ball.normals[i]) component = is_turned ? -component : component;
  }
  const Shares of_all = SharesOf(ball, 24);
  TestPoints noisy = ball;
  AddNoise(0.003, 1, noisy);
  for (size_t i = 0; i < ball.size(); ++i) {
    if (is_noisy(i)) ball.positions[i] = noisy.positions[i];
  }
  NormalFit fit = FitTo(24);
  fit.noisy_part = NoisyPart{.neighborhood = NeighborCount{24}, .probe_count = 24, .least_variance = 1e-8};
  const Shares of_parts = SharesOf(ball, fit);
  EXPECT_GT(of_parts.torn, 10.0 * of_all.torn);
  EXPECT_LT(of_parts.opposed, 2.0 * of_all.opposed + 0.001);
}

TEST(SideProbeTest, PointsWithoutNormalsSayNothing) {
  const TestPoints ball = Sphere(500, 1.0);
  SpatialIndex index = BuildIndex(ball.ToCloud());
  for (size_t place = 0; place < index.point_count(); ++place) {
    auto& normals = index.mutable_normals(place / SpatialIndex::kLeafSize);
    const size_t lane = place % SpatialIndex::kLeafSize;
    normals.x[lane] = normals.y[lane] = normals.z[lane] = std::numeric_limits<float>::quiet_NaN();
  }
  SideProbe probe(index, FitTo(12), 1);
  const std::atomic<bool> stopped = false;
  for (size_t block = 0; block < probe.block_count(); ++block) {
    EXPECT_TRUE(probe.RunBlock(block, 0, stopped).ok());
  }
  EXPECT_EQ(probe.OpposedShare(), 0.0);
  EXPECT_EQ(probe.TornShare(), 0.0);
}

TEST(SideProbeTest, StopsWhenNobodyWantsTheResult) {
  const SpatialIndex index = BuildIndex(Sphere(500, 1.0).ToCloud());
  SideProbe probe(index, FitTo(12), 1);
  const std::atomic<bool> stopped = true;
  EXPECT_FALSE(probe.RunBlock(0, 0, stopped).ok());
}

}  // namespace
}  // namespace curvd::testing
