#include "core/normals/normal_pilot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/estimators/triangles/random_stream.h"
#include "core/job/estimation_job.h"
#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

NormalOptions Automatic() {
  NormalOptions options;
  options.source = NormalSource::kEstimate;
  return options;
}

double Uniform(RandomStream& random) { return static_cast<double>(random.Next() >> 11) * 0x1p-53; }

TEST(NormalPilotTest, CleanSurfacesGetSmallNeighborhoodsOfHighDegree) {
  const NormalResult result = MustMakeNormals(BareCloud(Torus(25'000, 1)), Automatic());
  EXPECT_EQ(result.report.method, NormalMethod::kJet4);
  EXPECT_LE(result.report.neighbor_count, 48u);
  EXPECT_LT(*result.report.sigma, 1e-3);
}

TEST(NormalPilotTest, FindsTheNoise) {
  for (const double sigma : {0.03, 0.1, 0.2}) {
    TestPoints torus = Torus(25'000, 1);
    AddNoise(sigma, 2, torus);
    const NormalResult result = MustMakeNormals(BareCloud(torus), Automatic());
    // The median of a chi-squared variable is a little below its mean.
    EXPECT_NEAR(*result.report.sigma, sigma, 0.1 * sigma);
  }
}

// Along one line, or across few, fits follow the noise.
TEST(NormalPilotTest, ScanLinesAreCrossed) {
  for (const double gap : {3.0, 8.0, 20.0, 40.0}) {
    for (const double noise : {0.0, 0.3, 1.0}) {
      constexpr size_t kPoints = 12'000;
      const TestPoints saddle = ScannedSaddle(kPoints, gap, noise, 1);
      const NormalResult result = MustMakeNormals(BareCloud(saddle), Automatic());
      const double sigma = noise * 2.0 / std::sqrt(kPoints * gap);
      EXPECT_NEAR(*result.report.sigma, sigma, 0.12 * sigma + 1e-5) << gap << " " << noise;
      EXPECT_LT(MeanAngle(result.normals, saddle), noise == 0.0 ? 0.05 : 0.4) << gap << " " << noise;
      EXPECT_EQ(FlippedShare(result.normals, saddle), 0.0) << gap << " " << noise;
    }
  }
}

// Around the poles fits of the scale that is chosen for all cross two lines.
TEST(NormalPilotTest, PointsThatCrossFewLinesGetALowerDegree) {
  const TestPoints ellipsoid = ScannedEllipsoid(0.0015, 1);
  const NormalResult result = MustMakeNormals(BareCloud(ellipsoid), Automatic());
  EXPECT_EQ(result.report.status_counts[static_cast<size_t>(PointStatus::kOk)], ellipsoid.size());
  size_t far_off = 0;
  for (size_t i = 0; i < ellipsoid.size(); ++i) {
    far_off += IsFarOff(result.normals[i].normal, ellipsoid.normals[i]) ? 1 : 0;
  }
  EXPECT_LE(far_off, ellipsoid.size() / 1000);
}

// Along a strip the largest neighborhoods are narrow, too: that is no reason to take small ones.
TEST(NormalPilotTest, StripsKeepTheirLargeNeighborhoods) {
  TestPoints strip;
  RandomStream random(3, 4);
  for (int i = 0; i < 8'000; ++i) strip.Add(4.0 * Uniform(random), 0.04 * Uniform(random), 0.0, 0, 0, 1);
  AddNoise(0.002, 5, strip);
  const NormalResult result = MustMakeNormals(BareCloud(strip), Automatic());
  EXPECT_GE(result.report.neighbor_count, 384u);
  EXPECT_LT(MeanAngle(result.normals, strip), 3.0);
}

// Fits pass nearly through points that are there twice, and freedom counts less than it seems.
TEST(NormalPilotTest, CopiesOfNoisyPointsAreNoNews) {
  TestPoints torus = Torus(10'000, 1);
  const TestPoints exact = torus;
  AddNoise(0.1, 2, torus);
  const double alone = MeanAngle(MustMakeNormals(BareCloud(torus), Automatic()).normals, exact);
  for (const double rounding : {0.0, 1e-5}) {
    for (const size_t copies : {1'000, 4'000, 10'000, 20'000}) {
      TestPoints more, truth = exact;
      for (size_t i = 0; i < copies; ++i) {
        const size_t of = i % torus.size();
        more.positions.push_back(torus.positions[of]);
        more.normals.push_back(torus.normals[of]);
        truth.positions.push_back(exact.positions[of]);
        truth.normals.push_back(exact.normals[of]);
      }
      AddNoise(rounding, 5, more);
      TestPoints all = torus;
      Append(more, all);
      const NormalResult result = MustMakeNormals(BareCloud(all), Automatic());
      EXPECT_NEAR(*result.report.sigma, 0.1, 0.012) << copies;
      EXPECT_LT(MeanAngle(result.normals, truth), 1.3 * alone) << copies;
    }
  }
}

// Within 1.3 times of what the best of all scales and methods reaches.
TEST(NormalPilotTest, ChoosesNearlyTheBestScale) {
  for (const double sigma : {0.0, 0.03, 0.1}) {
    TestPoints torus = Torus(15'000, 3);
    AddNoise(sigma, 4, torus);
    double best = 180.0;
    for (const NormalMethod method : {NormalMethod::kPca, NormalMethod::kJet2, NormalMethod::kJet4}) {
      for (const uint32_t count : {24u, 48u, 96u, 192u, 384u}) {
        const NormalResult result = MustMakeNormals(BareCloud(torus), EstimateBy(method, count));
        best = std::min(best, MeanAngle(result.normals, torus));
      }
    }
    const NormalResult chosen = MustMakeNormals(BareCloud(torus), Automatic());
    EXPECT_LT(MeanAngle(chosen.normals, torus), 1.3 * best)
        << sigma << ": " << NormalMethodName(*chosen.report.method) << " " << chosen.report.neighbor_count;
  }
}

// PCA with whatever count is best for it: who does not choose by the noise cannot know that one.
TEST(NormalPilotTest, NormalsAloneAreAtLeastAsExactAsThoseOfTheBestPlanes) {
  for (const double sigma : {0.075, 0.2}) {
    TestPoints torus = Torus(25'000, 3);
    AddNoise(sigma, 4, torus);
    double best = 180.0;
    for (const uint32_t count : {272u, 384u, 544u}) {
      const NormalResult planes = MustMakeNormals(BareCloud(torus), EstimateBy(NormalMethod::kPca, count));
      best = std::min(best, MeanAngle(planes.normals, torus));
    }
    EXPECT_LE(MeanAngle(MustMakeNormals(BareCloud(torus), Automatic()).normals, torus), best) << sigma;
  }
}

// 400,000 points of 1,086 neighbors each are more than all points together may take: leaves share the fits.
TEST(NormalPilotTest, LargeNoisyCloudsShareFitsOfManyNeighbors) {
  TestPoints torus = Torus(400'000, 3);
  AddNoise(0.05, 4, torus);
  const NormalResult chosen = MustMakeNormals(BareCloud(torus), Automatic());
  EXPECT_EQ(chosen.report.neighbor_count, 1086u);
  const NormalResult own = MustMakeNormals(BareCloud(torus), EstimateBy(*chosen.report.method, 272));
  EXPECT_LT(MeanAngle(chosen.normals, torus), 0.75 * MeanAngle(own.normals, torus));
}

TEST(NormalPilotTest, CurvatureIsMadeOfNormalsThatAreSmoothedLess) {
  TestPoints torus = Torus(25'000, 3);
  AddNoise(0.15, 4, torus);
  WorkerPool pool(2);
  const auto curvature = EstimateCurvature(BareCloud(torus), EstimatorOptions(), Automatic(), pool);
  ASSERT_TRUE(curvature.ok()) << curvature.status();
  EXPECT_LT(curvature->normal_report->neighbor_count,
            MustMakeNormals(BareCloud(torus), Automatic()).report.neighbor_count);
}

TEST(NormalPilotTest, NothingDependsOnTheUnit) {
  TestPoints torus = Torus(5'000, 5);
  AddNoise(0.05, 6, torus);
  const NormalResult one = MustMakeNormals(BareCloud(torus), Automatic());
  for (auto& position : torus.positions) {
    for (float& coordinate : position) coordinate *= 0x1p20f;
  }
  const NormalResult other = MustMakeNormals(BareCloud(torus), Automatic());
  EXPECT_TRUE(SameBytes(one.normals, other.normals));
  EXPECT_EQ(*other.report.sigma, *one.report.sigma * 0x1p20);
}

TEST(NormalPilotTest, SmallAndHopelessCloudsGetAFallback) {
  for (const size_t points : {size_t{4}, size_t{11}, size_t{30}, size_t{40}}) {
    const NormalResult result = MustMakeNormals(BareCloud(Sphere(points, 1.0)), Automatic());
    EXPECT_EQ(result.report.status_counts[static_cast<size_t>(PointStatus::kOk)], points);
  }
  TestPoints line;
  for (int i = 0; i < 2000; ++i) line.Add(0.001 * i, 0, 0, 0, 0, 1);
  const NormalResult result = MustMakeNormals(BareCloud(line), Automatic());
  EXPECT_FALSE(result.report.sigma.has_value());
  EXPECT_EQ(result.report.status_counts[static_cast<size_t>(PointStatus::kSingularFit)], 2000u);
}

// Ground with shrubs: of few neighbors, normals of shrubs point anywhere, and with their neighbors' they make seams.
TEST(NormalPilotTest, RoughPartsGetLargerNeighborhoods) {
  const auto shrubs = [](double height) {
    TestPoints ground;
    RandomStream random(1, 2);
    for (int i = 0; i < 30'000; ++i) {
      const double x = Uniform(random), y = Uniform(random), bump = std::sin(9.0 * x) * std::sin(7.0 * y);
      const double z = 0.05 * bump + (bump > 0.3 ? height * Uniform(random) : 0.0);
      ground.Add(x, y, z, 0, 0, 1);
    }
    return MustMakeNormals(BareCloud(ground), Automatic()).report;
  };
  EXPECT_LE(shrubs(0.0).neighbor_count, 24u);
  const NormalReport rough = shrubs(0.03);
  EXPECT_LE(rough.neighbor_count, 24u);
  ASSERT_TRUE(rough.noisy_part.has_value());
  EXPECT_GE(rough.noisy_part->neighbor_count, 48u);
  EXPECT_NEAR(rough.noisy_part->share, 0.3, 0.1);
}

// A unit sphere, 1,000,000 units from the origin in single precision: its points lie on a lattice of 1/16.
TEST(NormalPilotTest, PositionsOnALatticeGetNormals) {
  const auto on_lattice = [](double coordinate) {
    return static_cast<double>(static_cast<float>(coordinate + 1e6) - 1e6f);
  };
  TestPoints sphere;
  RandomStream random(1, 2);
  for (int i = 0; i < 5'000; ++i) {
    const double z = 2.0 * Uniform(random) - 1.0, turn = 6.283185307179586 * Uniform(random);
    const double radius = std::sqrt(1.0 - z * z), x = radius * std::cos(turn), y = radius * std::sin(turn);
    sphere.Add(on_lattice(x), on_lattice(y), on_lattice(z), x, y, z);
  }
  const NormalResult result = MustMakeNormals(BareCloud(sphere), Automatic());
  EXPECT_GE(result.report.status_counts[static_cast<size_t>(PointStatus::kOk)], 4'950u);
  // What rounding to steps of 1/16 has done to the positions.
  EXPECT_GE(*result.report.sigma, 0.018);
  EXPECT_LT(MeanAngle(result.normals, sphere), 6.0);
}

TEST(NormalPilotTest, KeepsToTheWantedMethodAndLimit) {
  TestPoints torus = Torus(10'000, 7);
  AddNoise(0.2, 8, torus);
  NormalOptions options = Automatic();
  options.method = NormalMethod::kPca;
  options.max_neighbor_count = 40;
  const NormalResult result = MustMakeNormals(BareCloud(torus), options);
  EXPECT_EQ(result.report.method, NormalMethod::kPca);
  EXPECT_LE(result.report.neighbor_count, 40u);
}

}  // namespace
}  // namespace curvd::testing
