#include "core/normals/trust/jet_probe.h"

#include <gtest/gtest.h>

#include "tests/core/normals/trust/probed_clouds.h"

namespace curvd::testing {
namespace {

std::optional<NormalFit> ProbedJet(const TestPoints& points, uint32_t max_neighbor_count = 10'000,
                                   bool backwards = false) {
  return Probed<JetProbe>(points, max_neighbor_count, backwards);
}

TEST(JetProbeTest, FindsTheJetsThatNormalsAreThoseOf) {
  struct Case {
    NormalMethod method;
    uint32_t count;
  };
  for (const double sigma : {0.02, 0.05, 0.1}) {
    for (const Case& made : {Case{NormalMethod::kJet2, 24},
                             {NormalMethod::kJet2, 33},
                             {NormalMethod::kJet2, 60},
                             {NormalMethod::kJet4, 61},
                             {NormalMethod::kJet4, 80},
                             {NormalMethod::kJet4, 90}}) {
      const auto found = ProbedJet(WithFittedNormals(TorusWithNoise(sigma), made.method, made.count));
      ASSERT_TRUE(found.has_value()) << sigma << " " << NormalMethodName(made.method) << " " << made.count;
      EXPECT_EQ(found->method, made.method) << sigma << " " << made.count;
      EXPECT_EQ(ProbedCount(*found), made.count) << sigma << " " << NormalMethodName(made.method);
      EXPECT_FALSE(found->half.has_value());
    }
  }
}

// Halves of the neighbors share what bends do to jets.
TEST(JetProbeTest, JetsThatErrByBendsAreNotTold) {
  EXPECT_FALSE(ProbedJet(WithFittedNormals(TorusWithNoise(0.02), NormalMethod::kJet2, 300)).has_value());
}

// Half of so few neighbors determine no jet: planes have about that noise, too.
TEST(JetProbeTest, HalvesAreOfEnoughNeighbors) {
  const auto quadric = ProbedJet(WithFittedNormals(TorusWithNoise(0.05), NormalMethod::kJet2, 18));
  ASSERT_TRUE(quadric.has_value());
  EXPECT_EQ(quadric->method, NormalMethod::kPca);
  EXPECT_EQ(ProbedCount(*quadric), 18u);
  const auto quartic = ProbedJet(WithFittedNormals(TorusWithNoise(0.05), NormalMethod::kJet4, 48));
  ASSERT_TRUE(quartic.has_value());
  EXPECT_EQ(quartic->method, NormalMethod::kPca);
  EXPECT_EQ(ProbedCount(*quartic), 16u);
}

TEST(JetProbeTest, OtherNormalsAreThoseOfNoJet) {
  for (const ProbedCloud& cloud : CloudsWithOtherNormals()) {
    EXPECT_FALSE(ProbedJet(cloud.points).has_value()) << cloud.what;
  }
}

TEST(JetProbeTest, NormalsOfPlanesAreThoseOfNoJet) {
  EXPECT_FALSE(ProbedJet(WithFittedNormals(TorusWithNoise(0.05), NormalMethod::kPca, 40)).has_value());
}

// Where points are that dense and exact, jets are as good as exact.
TEST(JetProbeTest, JetsOfExactPositionsAreNotLookedFor) {
  EXPECT_FALSE(ProbedJet(WithFittedNormals(Sphere(20'000, 1.0), NormalMethod::kJet2, 40)).has_value());
}

TEST(JetProbeTest, SmallCloudsAndSmallLimitsTellNothing) {
  EXPECT_FALSE(ProbedJet(WithFittedNormals(Torus(60, 5), NormalMethod::kJet2, 20)).has_value());
  EXPECT_FALSE(ProbedJet(WithFittedNormals(TorusWithNoise(0.05), NormalMethod::kJet2, 60), 50).has_value());
}

TEST(JetProbeTest, TheOrderOfBlocksChangesNothing) {
  const TestPoints torus = WithFittedNormals(TorusWithNoise(0.05), NormalMethod::kJet2, 37);
  const auto forwards = ProbedJet(torus), backwards = ProbedJet(torus, 10'000, true);
  ASSERT_TRUE(forwards.has_value() && backwards.has_value());
  EXPECT_EQ(ProbedCount(*forwards), ProbedCount(*backwards));
  EXPECT_EQ(forwards->method, backwards->method);
}

TEST(JetProbeTest, EndsWhereItIsStopped) { ExpectEndsWhereStopped<JetProbe>(); }

TEST(JetProbeTest, PointsThatFixNoJetTellNothing) {
  for (const Layout layout : kLayouts) EXPECT_FALSE(ProbedJet(RandomPoints(layout, 2'000, 3)).has_value());
}

}  // namespace
}  // namespace curvd::testing
