#include "core/scale/chosen/blend.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

namespace curvd::testing {
namespace {

// Principal directions in the xy plane, the first at this angle from x.
PointCurvature Estimate(double k1, double k2, double angle) {
  const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
  return {static_cast<float>(0.5 * (k1 + k2)),
          static_cast<float>(k1 * k2),
          static_cast<float>(k1),
          static_cast<float>(k2),
          {c, s, 0.0f},
          {-s, c, 0.0f},
          1.0f,
          PointStatus::kOk};
}

TEST(BlendTest, OneEstimateStaysAsItIs) {
  Blend blend;
  blend.Add(Estimate(-0.5, 2.0, 0.3), {7.0, 7.0, 7.0});
  const PointCurvature point = blend.Finish();
  EXPECT_EQ(point.status, PointStatus::kOk);
  EXPECT_FLOAT_EQ(point.mean, 0.75f);
  EXPECT_FLOAT_EQ(point.gaussian, -1.0f);
  EXPECT_FLOAT_EQ(point.k1, -0.5f);
  EXPECT_FLOAT_EQ(point.k2, 2.0f);
  EXPECT_NEAR(std::abs(point.d1[0] * std::cos(0.3) + point.d1[1] * std::sin(0.3)), 1.0, 1e-6);
  EXPECT_NEAR(point.d1[0] * point.d2[1] - point.d1[1] * point.d2[0], 1.0, 1e-6) << "d1 x d2 is the normal";
}

TEST(BlendTest, AveragesShapeOperatorsAndNotTheirPrincipalCurvatures) {
  Blend blend;
  blend.Add(Estimate(0.0, 1.0, 0.0), {1.0, 1.0, 1.0});
  blend.Add(Estimate(0.0, 1.0, std::acos(0.0)), {1.0, 1.0, 1.0});
  const PointCurvature point = blend.Finish();
  EXPECT_NEAR(point.k1, 0.5, 1e-6) << "ridges across each other make a sphere";
  EXPECT_NEAR(point.k2, 0.5, 1e-6);
}

TEST(BlendTest, WeightsCount) {
  Blend blend;
  blend.Add(Estimate(1.0, 1.0, 0.0), {3.0, 3.0, 3.0});
  PointCurvature wide = Estimate(2.0, 2.0, 0.0);
  wide.radius = 5.0f;
  blend.Add(wide, {1.0, 1.0, 1.0});
  EXPECT_FLOAT_EQ(blend.Finish().mean, 1.25f);
  EXPECT_EQ(blend.Finish().radius, 5.0f) << "how far any of them looked";
}

TEST(BlendTest, SpreadIsThatOfTheEstimatesAroundTheirAverage) {
  Blend blend;
  EXPECT_EQ(blend.spread().mean, 0.0);
  blend.Add(Estimate(1.0, 3.0, 0.0), {3.0, 3.0, 3.0});
  EXPECT_EQ(blend.spread().mean, 0.0) << "one agrees with itself";
  blend.Add(Estimate(5.0, 5.0, 0.0), {1.0, 1.0, 1.0});
  blend.Add(Estimate(100.0, 100.0, 0.0), {0.0, 0.0, 0.0});
  const Blend::Spread spread = blend.spread();
  const double share = std::sqrt(0.75 * 0.25);
  EXPECT_NEAR(spread.mean, 3.0 * share, 1e-12);
  EXPECT_NEAR(spread.k1, 4.0 * share, 1e-12);
  EXPECT_NEAR(spread.k2, 2.0 * share, 1e-12);
  EXPECT_NEAR(blend.mean(), 2.75, 1e-12);
}

TEST(BlendTest, WhereEstimatesContradictEachOtherTheSteadyOneIsTheResult) {
  const PointCurvature steady = Estimate(1.0, 2.0, 0.3);
  const auto blend_with = [&](double other, std::optional<double> most_spread) {
    Blend blend;
    blend.Add(steady, {1.0, 1.0, 1.0}, most_spread);
    blend.Add(Estimate(other - 0.5, other + 0.5, 0.3), {1.0, 1.0, 1.0});
    return blend;
  };
  // The spread is half of what they differ by.
  EXPECT_TRUE(blend_with(2.0, 0.01).IsContradictory());
  EXPECT_EQ(blend_with(2.0, 0.01).Finish().mean, steady.mean);
  EXPECT_EQ(blend_with(2.0, 0.01).Finish().k1, steady.k1);
  EXPECT_EQ(blend_with(2.0, 0.01).mean(), 1.5);
  EXPECT_FALSE(blend_with(1.7, 0.01).IsContradictory()) << "by less than a tenth of k2";
  EXPECT_FALSE(blend_with(2.0, 0.26).IsContradictory()) << "that is expected";
  EXPECT_FALSE(blend_with(2.0, std::nullopt).IsContradictory()) << "none is steady";
  EXPECT_EQ(blend_with(2.0, std::nullopt).mean(), 1.75);
}

TEST(BlendTest, EachQuantityHasWeightsOfItsOwn) {
  Blend blend;
  blend.Add(Estimate(0.5, 1.5, 0.3), {3.0, 1.0, 0.0});
  blend.Add(Estimate(1.0, 5.0, 0.3), {1.0, 3.0, 2.0});
  const PointCurvature point = blend.Finish();
  EXPECT_FLOAT_EQ(point.mean, 1.5f);
  EXPECT_NEAR(point.k1, 1.5 - 1.625, 1e-6);
  EXPECT_NEAR(point.k2, 1.5 + 1.625, 1e-6);
  EXPECT_FLOAT_EQ(point.gaussian, 5.0f);
  // H is 1 and 3, half of k2 - k1 is 0.5 and 2; both change together.
  const double of_mean = 2.0 * std::sqrt(0.75 * 0.25), of_half = 1.5 * std::sqrt(0.75 * 0.25);
  EXPECT_NEAR(blend.spread().mean, of_mean, 1e-12);
  EXPECT_GE(blend.spread().k1, of_mean - of_half);
  EXPECT_LE(blend.spread().k2, of_mean + of_half);
  EXPECT_GT(blend.spread().k2, blend.spread().k1);
}

TEST(BlendTest, OneWithoutWeightDoesNotEvenTellItsRadius) {
  Blend blend;
  blend.Add(Estimate(1.0, 1.0, 0.0), {3.0, 3.0, 3.0});
  PointCurvature wide = Estimate(2.0, 2.0, 0.0);
  wide.radius = 5.0f;
  blend.Add(wide, {0.0, 0.0, 0.0});
  EXPECT_FLOAT_EQ(blend.Finish().mean, 1.0f);
  EXPECT_EQ(blend.Finish().radius, 1.0f);
}

TEST(BlendTest, WhatCouldNotBeEstimatedDoesNotCount) {
  Blend blend;
  blend.Add(UndefinedCurvature(PointStatus::kSingularFit), {100.0, 100.0, 100.0});
  blend.Add(Estimate(1.0, 2.0, 0.1), {1.0, 1.0, 1.0});
  EXPECT_EQ(blend.Finish().status, PointStatus::kOk);
  EXPECT_FLOAT_EQ(blend.Finish().mean, 1.5f);
}

TEST(BlendTest, WithoutAnyTheLargestWeightSaysWhy) {
  Blend blend;
  blend.Add(UndefinedCurvature(PointStatus::kSingularFit), {1.0, 1.0, 1.0});
  blend.Add(UndefinedCurvature(PointStatus::kDegenerateArea), {2.0, 2.0, 2.0});
  const PointCurvature point = blend.Finish();
  EXPECT_EQ(point.status, PointStatus::kDegenerateArea);
  EXPECT_TRUE(std::isnan(point.mean) && std::isnan(point.k1) && std::isnan(point.d1[0]));
  EXPECT_NE(Blend().Finish().status, PointStatus::kOk);
}

TEST(BlendTest, OppositeNormalsAreNoSurface) {
  Blend blend;
  blend.Add(Estimate(1.0, 1.0, 0.0), {1.0, 1.0, 1.0});
  PointCurvature turned = Estimate(1.0, 1.0, 0.0);
  turned.d1 = {0.0f, 1.0f, 0.0f}, turned.d2 = {1.0f, 0.0f, 0.0f};
  blend.Add(turned, {1.0, 1.0, 1.0});
  EXPECT_EQ(blend.Finish().status, PointStatus::kInconsistentNormals);
}

}  // namespace
}  // namespace curvd::testing
