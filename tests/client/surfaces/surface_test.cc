#include "client/surfaces/surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "client/surfaces/random.h"

namespace curv {
namespace {

std::unique_ptr<Surface> Make(std::string_view name) { return *MakeSurface(name); }

std::vector<Vec3> Samples(const Surface& surface) { return *SampleEvenly(surface, 300, /*seed=*/7); }

class EverySurfaceTest : public ::testing::TestWithParam<std::string_view> {};

TEST_P(EverySurfaceTest, GradientAndHessianAreDerivatives) {
  const auto surface = Make(GetParam());
  const double step = 1e-5 * Norm(surface->bounds().high - surface->bounds().low);
  for (const Vec3& p : Samples(*surface)) {
    const ImplicitJet jet = surface->Jet(p);
    const Vec3 rows[] = {{jet.hessian_diagonal.x, jet.hessian_off_diagonal.z, jet.hessian_off_diagonal.y},
                         {jet.hessian_off_diagonal.z, jet.hessian_diagonal.y, jet.hessian_off_diagonal.x},
                         {jet.hessian_off_diagonal.y, jet.hessian_off_diagonal.x, jet.hessian_diagonal.z}};
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 ahead = p, behind = p, gradient_ahead, gradient_behind;
      ahead[axis] += step;
      behind[axis] -= step;
      const double slope =
          (surface->Evaluate(ahead, gradient_ahead) - surface->Evaluate(behind, gradient_behind)) / (2.0 * step);
      // Central differences leave a share of step^2, about 1e-8 here, of the third derivative.
      EXPECT_NEAR(jet.gradient[axis], slope, 1e-6 * (1.0 + std::abs(slope)));
      const Vec3 bend = (0.5 / step) * (gradient_ahead - gradient_behind);
      EXPECT_LT(Norm(rows[axis] - bend), 1e-6 * (1.0 + Norm(bend)));
    }
  }
}

// The shape operator by differences of the normal along the surface, without the Hessian.
TEST_P(EverySurfaceTest, CurvatureIsHowTheNormalTurns) {
  const auto surface = Make(GetParam());
  const double step = 1e-5 * Norm(surface->bounds().high - surface->bounds().low);
  for (const Vec3& p : Samples(*surface)) {
    const SurfaceGeometry geometry = surface->At(p);
    for (const auto& [direction, curvature] :
         {std::pair{geometry.d1, geometry.k1}, std::pair{geometry.d2, geometry.k2}}) {
      const Vec3 ahead = surface->At(surface->Project(p + step * direction)).normal;
      const Vec3 behind = surface->At(surface->Project(p - step * direction)).normal;
      const Vec3 turn = (0.5 / step) * (ahead - behind);
      EXPECT_LT(Norm(turn - curvature * direction), 1e-6 * (1.0 + std::abs(curvature)));
    }
  }
}

TEST_P(EverySurfaceTest, KeepsTheConventions) {
  const auto surface = Make(GetParam());
  for (const Vec3& p : Samples(*surface)) {
    const SurfaceGeometry g = surface->At(p);
    EXPECT_LE(g.k1, g.k2);
    EXPECT_NEAR(g.mean, 0.5 * (g.k1 + g.k2), 1e-14);
    EXPECT_NEAR(g.gaussian, g.k1 * g.k2, 1e-13);
    EXPECT_NEAR(Norm(g.normal), 1.0, 1e-14);
    EXPECT_NEAR(Norm(g.d1), 1.0, 1e-14);
    EXPECT_LT(Norm(Cross(g.d1, g.d2) - g.normal), 1e-14);
  }
}

TEST_P(EverySurfaceTest, ProjectsOntoTheSurface) {
  const auto surface = Make(GetParam());
  const double size = Norm(surface->bounds().high - surface->bounds().low);
  const CounterRandom random(1, 2);
  uint64_t draw = 0;
  for (const Vec3& p : Samples(*surface)) {
    Vec3 moved = p;
    for (int axis = 0; axis < 3; ++axis) moved[axis] += 0.02 * size * (random.Uniform(draw++) - 0.5);
    const Vec3 projected = surface->Project(moved);
    Vec3 gradient;
    const double value = surface->Evaluate(projected, gradient);
    EXPECT_LE(std::abs(value), 1e-13 * size * Norm(gradient));
    // As far as the nearest position is, but for the curvature on the way.
    EXPECT_LE(Norm(projected - moved), 1.2 * Norm(p - moved));
  }
}

INSTANTIATE_TEST_SUITE_P(Surfaces, EverySurfaceTest, ::testing::ValuesIn(SurfaceNames()),
                         [](const auto& test) { return std::string(test.param); });

TEST(SurfaceTest, SphereHasCurvatureOne) {
  const SurfaceGeometry g = Make("sphere")->At({0, 0.6, 0.8});
  EXPECT_NEAR(g.mean, 1.0, 1e-15);
  EXPECT_NEAR(g.gaussian, 1.0, 1e-15);
  EXPECT_NEAR(Dot(g.normal, {0, 0.6, 0.8}), 1.0, 1e-15);
}

TEST(SurfaceTest, TorusIsCurvedOutsideAndInside) {
  const auto torus = Make("torus");
  const SurfaceGeometry outside = torus->At({8, 0, 0});
  EXPECT_NEAR(outside.k1, 1.0 / 8, 1e-15);
  EXPECT_NEAR(outside.k2, 1.0 / 2, 1e-15);
  EXPECT_NEAR(std::abs(outside.d2.z), 1.0, 1e-15);
  const SurfaceGeometry inside = torus->At({0, 4, 0});
  EXPECT_NEAR(inside.k1, -1.0 / 4, 1e-15);
  EXPECT_NEAR(inside.k2, 1.0 / 2, 1e-15);
  EXPECT_NEAR(inside.normal.y, -1.0, 1e-15);
}

TEST(SurfaceTest, CylinderIsStraightAlongItsAxis) {
  const SurfaceGeometry g = Make("cylinder")->At({0, -1, 0.5});
  EXPECT_NEAR(g.k1, 0.0, 1e-15);
  EXPECT_NEAR(g.k2, 1.0, 1e-15);
  EXPECT_NEAR(std::abs(g.d1.z), 1.0, 1e-15);
}

TEST(SurfaceTest, SaddleBendsBothWays) {
  const SurfaceGeometry g = Make("saddle")->At({0, 0, 0});
  EXPECT_EQ(g.normal, (Vec3{0, 0, 1}));
  EXPECT_NEAR(g.k1, -1.0, 1e-15);
  EXPECT_NEAR(g.k2, 1.0, 1e-15);
  EXPECT_NEAR(std::abs(g.d1.x), 1.0, 1e-15);
}

TEST(SurfaceTest, EllipsoidHasTheCurvatureOfItsAxes) {
  // At the end of the long axis: a / c^2 and a / b^2 with a = 3, b = 2, c = 1.
  const SurfaceGeometry g = Make("ellipsoid")->At({3, 0, 0});
  EXPECT_NEAR(g.k1, 3.0 / 4, 1e-14);
  EXPECT_NEAR(g.k2, 3.0, 1e-14);
}

TEST(SurfaceTest, GoursatMatchesThePaper) {
  // The range of the mean curvature in the paper's Figure 6 is [-0.107, 0.345], of the Gaussian [-0.034, 0.119].
  const auto goursat = Make("goursat");
  double low_mean = 0, high_mean = 0, low_gaussian = 0, high_gaussian = 0;
  const std::vector<Vec3> points = *SampleEvenly(*goursat, 20'000, 0);
  for (const Vec3& p : points) {
    const SurfaceGeometry g = goursat->At(p);
    low_mean = std::min(low_mean, g.mean);
    high_mean = std::max(high_mean, g.mean);
    low_gaussian = std::min(low_gaussian, g.gaussian);
    high_gaussian = std::max(high_gaussian, g.gaussian);
  }
  // 20,000 points meet the extrema to a percent or two; the figures are printed to three digits.
  EXPECT_NEAR(low_mean, -0.107, 0.002);
  EXPECT_NEAR(high_mean, 0.345, 0.002);
  EXPECT_NEAR(low_gaussian, -0.034, 0.001);
  EXPECT_NEAR(high_gaussian, 0.119, 0.001);
}

TEST(SurfaceTest, KnowsTheDistanceToBorders) {
  EXPECT_EQ(Make("torus")->DistanceToBorder({8, 0, 0}), std::numeric_limits<double>::infinity());
  EXPECT_DOUBLE_EQ(Make("cylinder")->DistanceToBorder({1, 0, 1.75}), 0.25);
  EXPECT_DOUBLE_EQ(Make("plane")->DistanceToBorder({-0.9, 0.5, 0}), 0.1);
}

TEST(SurfaceTest, RefusesOtherNames) {
  EXPECT_THAT(MakeSurface("klein").status().message(), ::testing::HasSubstr("\"klein\" is not known"));
}

}  // namespace
}  // namespace curv
