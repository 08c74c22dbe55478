#include "core/normals/trust/fit_probe.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "tests/core/normals/normal_clouds.h"
#include "tests/core/sanitized.h"

namespace curvd::testing {
namespace {

constexpr size_t kPoints = kSanitized ? 3'000 : 8'000;

// What the probe finds in a cloud's own normals; the blocks run in order, or the last ones first.
std::optional<NormalFit> ProbedFit(const TestPoints& points, uint32_t max_neighbor_count = 10'000,
                                   bool backwards = false) {
  const SpatialIndex index = BuildIndex(points.ToCloud());
  FitProbe probe(index, max_neighbor_count, 1);
  const std::atomic<bool> stopped = false;
  while (probe.AddFits()) {
    for (size_t i = 0; i < probe.block_count(); ++i) {
      const size_t block = backwards ? probe.block_count() - 1 - i : i;
      EXPECT_TRUE(probe.RunBlock(block, 0, stopped).ok());
    }
  }
  return probe.found();
}

uint32_t CountOf(const NormalFit& fit) { return std::get<NeighborCount>(fit.neighborhood).count; }

// The points with normals that are made of their positions, on the sides that they had.
TestPoints WithFittedNormals(TestPoints points, NormalMethod method, uint32_t count) {
  const NormalResult made = MustMakeNormals(BareCloud(points), EstimateBy(method, count));
  for (size_t i = 0; i < points.size(); ++i) {
    if (made.normals[i].status != PointStatus::kOk) continue;
    std::array<float, 3> normal = made.normals[i].normal;
    const float side =
        normal[0] * points.normals[i][0] + normal[1] * points.normals[i][1] + normal[2] * points.normals[i][2];
    if (side < 0.0f) normal = {-normal[0], -normal[1], -normal[2]};
    points.normals[i] = normal;
  }
  return points;
}

TestPoints NoisyTorus(double sigma) {
  TestPoints torus = Torus(kPoints, 5);
  AddNoise(sigma, 6, torus);
  return torus;
}

void AddNormalNoise(double sigma, TestPoints& points) {
  TestPoints moved;
  moved.positions = points.normals;
  AddNoise(sigma, 7, moved);
  for (size_t i = 0; i < points.size(); ++i) {
    const auto& n = moved.positions[i];
    const float length = std::hypot(n[0], n[1], n[2]);
    points.normals[i] = {n[0] / length, n[1] / length, n[2] / length};
  }
}

TEST(FitProbeTest, FindsTheFitThatNormalsAreThoseOf) {
  struct Case {
    NormalMethod method;
    uint32_t count;
  };
  for (const double sigma : {0.05, 0.1}) {
    for (const Case& made : {Case{NormalMethod::kPca, 12},
                             {NormalMethod::kPca, 20},
                             {NormalMethod::kPca, 29},
                             {NormalMethod::kPca, 50},

                             {NormalMethod::kJet2, 24},
                             {NormalMethod::kJet2, 60},
                             {NormalMethod::kJet4, 80}}) {
      const auto found = ProbedFit(WithFittedNormals(NoisyTorus(sigma), made.method, made.count));
      ASSERT_TRUE(found.has_value()) << sigma << " " << NormalMethodName(made.method) << " " << made.count;
      EXPECT_NEAR(std::log2(static_cast<double>(CountOf(*found)) / made.count), 0.0, 0.13)
          << sigma << " " << NormalMethodName(made.method) << " " << made.count;
      EXPECT_FALSE(found->half.has_value());
    }
  }
}

// Halves of so few neighbors would tell nothing: planes of more have that noise, too.
TEST(FitProbeTest, HalvesAreOfEnoughNeighbors) {
  const auto few = ProbedFit(WithFittedNormals(NoisyTorus(0.05), NormalMethod::kPca, 10));
  ASSERT_TRUE(few.has_value());
  EXPECT_EQ(few->method, NormalMethod::kPca);
  EXPECT_EQ(CountOf(*few), 12u);
  const auto quartic = ProbedFit(WithFittedNormals(NoisyTorus(0.05), NormalMethod::kJet4, 48));
  ASSERT_TRUE(quartic.has_value());
  EXPECT_EQ(quartic->method, NormalMethod::kPca) << "half of 48 neighbors determine no jet of degree 4";
  EXPECT_NEAR(CountOf(*quartic), 16.0, 2.0);
}

TEST(FitProbeTest, ExactNormalsAreThoseOfNoFit) {
  for (const double sigma : {0.0, 0.003, 0.02, 0.1, 0.3}) {
    EXPECT_FALSE(ProbedFit(NoisyTorus(sigma)).has_value()) << sigma;
    EXPECT_FALSE(ProbedFit(Waves(kPoints, sigma / 20.0, 8)).has_value()) << sigma;
    EXPECT_FALSE(ProbedFit(Waves(600, sigma / 20.0, 9)).has_value()) << sigma;
  }
}

TEST(FitProbeTest, NormalsWithNoiseOfTheirOwnAreThoseOfNoFit) {
  for (const double sigma : {0.003, 0.02, 0.1}) {
    for (const double of_normals : {0.01, 0.05, 0.2}) {
      TestPoints torus = NoisyTorus(sigma);
      AddNormalNoise(of_normals, torus);
      EXPECT_FALSE(ProbedFit(torus).has_value()) << sigma << " " << of_normals;
    }
  }
}

// Where planes and jets of few neighbors are turned by chance across a line, much seems to be noise.
TEST(FitProbeTest, ExactNormalsOnLinesAreThoseOfNoFit) {
  for (const double sigma : {0.0005, 0.002, 0.005}) {
    for (const double width : {0.0, 0.005, 0.02}) {
      TestPoints rings;
      for (size_t i = 0; i < 4'000; ++i) {
        const double turn = 2.39996 * static_cast<double>(i),
                     height = width * (static_cast<double>(i % 97) / 97.0 - 0.5);
        rings.Add(std::cos(turn), std::sin(turn), width > 0.0 ? height : 0.125 * static_cast<double>(i % 16),
                  std::cos(turn), std::sin(turn), 0.0);
      }
      AddNoise(sigma, 4, rings);
      EXPECT_FALSE(ProbedFit(rings).has_value()) << sigma << " " << width;
    }
  }
}

// Nine points to a wave, which planes follow better than jets of many neighbors.
TEST(FitProbeTest, ExactNormalsOfTooFewPointsAreThoseOfNoFit) {
  for (const double sigma : {0.0, 0.002, 0.01}) {
    TestPoints waves;
    for (int i = 0; i < 3'600; ++i) {
      const double x = (i % 60) / 30.0 - 1.0, y = (i / 60) / 30.0 - 1.0, f = 20.0;
      const double dx = -0.4 * std::cos(f * x) * std::cos(f * y), dy = 0.4 * std::sin(f * x) * std::sin(f * y);
      const double length = std::sqrt(1.0 + dx * dx + dy * dy);
      waves.Add(x, y, 0.4 / f * std::sin(f * x) * std::cos(f * y), dx / length, dy / length, 1.0 / length);
    }
    AddNoise(sigma, 4, waves);
    EXPECT_FALSE(ProbedFit(waves).has_value()) << sigma;
  }
}

TEST(FitProbeTest, ExactNormalsOfTwoSheetsAreThoseOfNoFit) {
  for (const double sigma : {0.0, 0.002, 0.005}) {
    for (const double gap : {0.05, 0.1, 0.2}) {
      TestPoints shell = Sphere(2'000, 1.0);
      TestPoints inner = Sphere(2'000, 1.0 - gap);
      for (auto& normal : inner.normals) normal = {-normal[0], -normal[1], -normal[2]};
      Append(inner, shell);
      AddNoise(sigma, 4, shell);
      EXPECT_FALSE(ProbedFit(shell).has_value()) << sigma << " " << gap;
    }
  }
}

// Noise of their own outweighs what such normals share.
TEST(FitProbeTest, MuchNoiseOfTheirOwnIsAllThatCounts) {
  TestPoints torus = WithFittedNormals(NoisyTorus(0.01), NormalMethod::kPca, 20);
  AddNormalNoise(0.2, torus);
  EXPECT_FALSE(ProbedFit(torus).has_value());
}

TEST(FitProbeTest, SmallCloudsAndSmallLimitsTellNothing) {
  const TestPoints small = WithFittedNormals(Torus(150, 5), NormalMethod::kPca, 12);
  EXPECT_FALSE(ProbedFit(small).has_value());
  EXPECT_FALSE(ProbedFit(WithFittedNormals(NoisyTorus(0.05), NormalMethod::kPca, 12), 16).has_value());
}

TEST(FitProbeTest, TheOrderOfBlocksChangesNothing) {
  const TestPoints torus = WithFittedNormals(NoisyTorus(0.05), NormalMethod::kPca, 22);
  const auto forwards = ProbedFit(torus), backwards = ProbedFit(torus, 10'000, true);
  ASSERT_TRUE(forwards.has_value() && backwards.has_value());
  EXPECT_EQ(CountOf(*forwards), CountOf(*backwards));
  EXPECT_EQ(forwards->method, backwards->method);
}

TEST(FitProbeTest, EndsWhereItIsStopped) {
  const SpatialIndex index = BuildIndex(NoisyTorus(0.05).ToCloud());
  FitProbe probe(index, 10'000, 1);
  const std::atomic<bool> stopped = true;
  ASSERT_TRUE(probe.AddFits());
  EXPECT_EQ(probe.RunBlock(0, 0, stopped).code(), absl::StatusCode::kCancelled);
}

TEST(FitProbeTest, PointsThatFixNoPlaneTellNothing) {
  for (const Layout layout : kLayouts) ProbedFit(RandomPoints(layout, 2'000, 3));
}

}  // namespace
}  // namespace curvd::testing
