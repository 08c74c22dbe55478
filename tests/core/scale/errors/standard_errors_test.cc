#include "core/scale/errors/standard_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

namespace curvd::testing {
namespace {

std::vector<uint32_t> FirstOf(size_t count) {
  std::vector<uint32_t> places(count);
  std::iota(places.begin(), places.end(), 0u);
  return places;
}

ErrorSample Known() {
  ErrorSample sample;
  sample.is_known = true;
  return sample;
}

TEST(ErrorModelTest, AddsUpNoiseDetailAndPlaceOfTheSamples) {
  ErrorSample sample = Known();
  sample.noise = {4.0, 9.0, 16.0, 0.0};
  sample.detail = {1.0, 2.0, 3.0, 0.0};
  sample.place = {2.0, 3.0, 4.0, 0.0};
  sample.noise_bias = 2.0;
  const ErrorModel model(std::vector<ErrorSample>(10, sample));
  // Far from umbilic.
  const StandardErrors errors = model.At(FirstOf(10), 0.0, 1e9);
  EXPECT_DOUBLE_EQ(errors.mean, 3.0);
  EXPECT_NEAR(errors.k1, 4.0, 1e-6);
  EXPECT_NEAR(errors.k2, 5.0, 1e-6);
}

TEST(ErrorModelTest, ProductsThatAreNegativeOnAverageCountAsNone) {
  ErrorSample up = Known(), down = Known();
  up.noise[kMeanPart] = down.noise[kMeanPart] = 1.0;
  up.detail[kMeanPart] = up.place[kMeanPart] = 1.0;
  down.detail[kMeanPart] = down.place[kMeanPart] = -3.0;
  std::vector<ErrorSample> samples(8, up);
  samples.resize(16, down);
  EXPECT_DOUBLE_EQ(ErrorModel(samples).At(FirstOf(16), 0.0, 1e9).mean, 1.0);
}

TEST(ErrorModelTest, UmbilicPointsHavePrincipalCurvaturesThatNoiseDrivesApart) {
  ErrorSample sample = Known();
  sample.noise = {1.0, 2.0, 2.0, 1.0};
  const ErrorModel model(std::vector<ErrorSample>(10, sample));
  // H has variance 1, and k2 is a Rayleigh length above it: pi / 2 + 2, near the mean square 3 of their sum.
  const StandardErrors at_umbilic = model.At(FirstOf(10), 0.0, 0.0), far_from_it = model.At(FirstOf(10), 0.0, 100.0);
  EXPECT_NEAR(at_umbilic.k2 * at_umbilic.k2, 2.0 + std::acos(-1.0) / 2.0, 1e-3);
  EXPECT_NEAR(far_from_it.k2 * far_from_it.k2, 2.0, 1e-2);
  EXPECT_EQ(at_umbilic.mean, far_from_it.mean);
}

TEST(ErrorModelTest, ALeanOfTheMeanAddsToOnePrincipalCurvatureAndTakesFromTheOther) {
  ErrorSample sample = Known();
  sample.noise = {1.0, 2.0, 2.0, 1.0};
  sample.lean = 0.5;
  const StandardErrors errors = ErrorModel(std::vector<ErrorSample>(10, sample)).At(FirstOf(10), 0.0, 0.0);
  EXPECT_GT(errors.k2, errors.k1);
}

TEST(ErrorModelTest, WhereCurvatureIsExtremeWhatSmoothingDrawsToTheMeanIsTheDetail) {
  ErrorSample sample = Known();
  sample.noise = {9.0, 9.0, 9.0, 0.0};
  sample.detail = {7.0, 7.0, 7.0, 0.0};
  Attenuation attenuation;
  attenuation.of[kMeanPart] = {0.5, 2.0};
  const ErrorModel model(std::vector<ErrorSample>(10, sample), attenuation);
  EXPECT_DOUBLE_EQ(model.At(FirstOf(10), 10.0, 1e9).mean, 5.0) << "half of 10 - 2 is lost";
  EXPECT_DOUBLE_EQ(model.At(FirstOf(10), -6.0, 1e9).mean, 5.0);
  EXPECT_DOUBLE_EQ(model.At(FirstOf(10), 3.0, 1e9).mean, 4.0) << "the samples nearby show more";
  EXPECT_NEAR(model.At(FirstOf(10), 10.0, 1e9).k2, 4.0, 1e-6) << "k1 and k2 have slopes of their own";
}

TEST(ErrorModelTest, NeverFallsBelowWhatCanBeTold) {
  ErrorSample sample = Known();
  sample.floor = 1e-6;
  const StandardErrors errors = ErrorModel(std::vector<ErrorSample>(10, sample)).At(FirstOf(10), 0.0, 1.0);
  EXPECT_GE(errors.mean, 1e-6);
  EXPECT_GE(errors.k1, 1e-6);
  EXPECT_GE(errors.k2, 1e-6);
}

TEST(ErrorModelTest, SaysNothingWhereTooFewSamplesAreKnown) {
  EXPECT_TRUE(std::isnan(ErrorModel().At({}, 0.0, 1.0).mean));
  EXPECT_TRUE(std::isnan(ErrorModel().At(FirstOf(3), 0.0, 1.0).mean)) << "sampled, but of no choice";
  std::vector<ErrorSample> samples(24);
  for (size_t i = 0; i < ErrorModel::kLeastNearest - 1; ++i) samples[i] = Known();
  EXPECT_TRUE(std::isnan(ErrorModel(samples).At(FirstOf(24), 0.0, 1.0).k1));
  samples[20] = Known();
  EXPECT_FALSE(std::isnan(ErrorModel(samples).At(FirstOf(24), 0.0, 1.0).k1));
  EXPECT_FALSE(std::isnan(ErrorModel({Known(), Known()}).At(FirstOf(2), 0.0, 1.0).k2)) << "there are no more";
}

TEST(NormalNoiseTest, IsWhatThePositionsDoNotExplain) {
  constexpr size_t kRung = 4;
  PilotPoint point({0.0f, 0.0f, 0.0f});
  EXPECT_FALSE(NormalNoise(std::span(&point, 1), 0.0).has_value());
  point.normal_residual[kRung] = 0.5f;
  for (PilotPoint::Estimates* const estimates : {&point.mean, &point.difference, &point.twist}) {
    (*estimates)[kRegressionMethod][kRung][PilotPoint::kAll] = 0.0f;
  }
  point.mean[kRegressionMethod][kRung][PilotPoint::kAll] = 3.0f;
  EXPECT_NEAR(*NormalNoise(std::span(&point, 1), 0.0), 0.5, 1e-6);
  EXPECT_NEAR(*NormalNoise(std::span(&point, 1), 0.1), 0.4, 1e-6) << "0.5^2 - (3 * 0.1)^2";
  EXPECT_EQ(*NormalNoise(std::span(&point, 1), 0.2), 0.0);
}

}  // namespace
}  // namespace curvd::testing
