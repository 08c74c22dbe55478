// Standard errors and the other choices of points.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/estimators/point_choice.h"
#include "tests/core/scale/automatic_requests.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

// Of the points whose standard error is known, how many have a true H within 1.645 of it.
double ShareWithin(const EstimationResult& result, double truth) {
  size_t known = 0, within = 0;
  for (size_t i = 0; i < result.choices.size(); ++i) {
    const double error = result.choices[i].mean_error;
    if (std::isnan(error)) continue;
    ++known;
    within += std::abs(result.field.points[i].mean - truth) <= 1.645 * error ? 1 : 0;
  }
  EXPECT_GT(known, 0u);
  return static_cast<double>(within) / static_cast<double>(known);
}

TEST(PointChoicesTest, NineInTenIntervalsHoldTheTruth) {
  EstimatorOptions hexagram{.neighborhood = NeighborCount{100}};
  for (const EstimatorOptions& options : {Automatic(), hexagram}) {
    for (const double sigma : {0.003, 0.01}) {
      const double share = ShareWithin(MustEstimate(NoisySphere(10'000, sigma).ToCloud(), WithChoice(options)), 1.0);
      // A sphere has no place where the surface changes: neighborhoods of several hundred points are few, and so are
      // independent errors among 10,000. What looks all around a body is doubted, so that all of them may be within.
      EXPECT_GT(share, 0.8) << sigma;
      EXPECT_TRUE(share < 0.999 || options.estimator == kAutomaticEstimator) << sigma;
    }
  }
}

TEST(PointChoicesTest, StandardErrorsGrowWithTheNoise) {
  const auto median = [](double sigma) {
    const EstimationResult result = MustEstimate(NoisySphere(5'000, sigma).ToCloud(), WithChoice(Automatic()));
    std::vector<float> errors;
    for (const PointChoice& choice : result.choices.span()) errors.push_back(choice.mean_error);
    std::nth_element(errors.begin(), errors.begin() + 2'500, errors.end());
    return errors[2'500];
  };
  const float exact = median(0.0), some = median(0.003), much = median(0.02);
  EXPECT_GT(exact, 0.0f);
  EXPECT_GT(some, 3.0f * exact);
  EXPECT_GT(much, 3.0f * some);
}

TEST(PointChoicesTest, ChoicesTellTheMeanCountAndTheWeightsOfTheEstimators) {
  const EstimationResult result = MustEstimate(NoisySphere(5'000, 0.01).ToCloud(), WithChoice(Automatic()));
  ASSERT_EQ(result.choices.size(), 5'000u);
  for (size_t i = 0; i < 5'000; i += 97) {
    const PointChoice& choice = result.choices[i];
    EXPECT_TRUE(choice.neighbor_count >= 16.0f && choice.neighbor_count <= 2048.0f) << choice.neighbor_count;
    EXPECT_NEAR(SumOfWeights(choice), 1.0f, 1e-5f);
  }
  EstimatorOptions jets{.estimator = "jet", .neighborhood = NeighborCount{100}};
  jets.jet_degree = 4;
  const EstimationResult fixed = MustEstimate(NoisySphere(5'000, 0.01).ToCloud(), WithChoice(jets));
  EXPECT_EQ(fixed.choices[7].neighbor_count, 100.0f);
  EXPECT_EQ(fixed.choices[7].jet_weight, 1.0f);
}

TEST(PointChoicesTest, AskingForChoicesChangesNoByteOfCurvature) {
  const TestPoints sphere = NoisySphere(3'000, 0.01);
  for (const EstimatorOptions& options : {Automatic(), EstimatorOptions{.neighborhood = NeighborCount{50}}}) {
    const EstimationResult with = MustEstimate(sphere.ToCloud(), WithChoice(options));
    const EstimationResult without = MustEstimate(sphere.ToCloud(), options);
    EXPECT_EQ(FirstDifference(with.field.points.span(), without.field.points.span()), 3'000u);
    EXPECT_EQ(with.field.status_counts, without.field.status_counts);
    EXPECT_EQ(without.choices.size(), 0u);
  }
}

TEST(PointChoicesTest, NeitherThreadsNorUnitChangeAByteOfChoices) {
  TestPoints sphere = NoisySphere(5'000, 0.01);
  const EstimationResult one = MustEstimate(sphere.ToCloud(), WithChoice(Automatic()), 1);
  const EstimationResult three = MustEstimate(sphere.ToCloud(), WithChoice(Automatic()), 3);
  EXPECT_TRUE(AreSameBytes(one.choices, three.choices));
  for (auto& position : sphere.positions) {
    for (float& coordinate : position) coordinate *= 0x1p20f;
  }
  const EstimationResult large = MustEstimate(sphere.ToCloud(), WithChoice(Automatic()));
  for (size_t i = 0; i < 5'000; ++i) EXPECT_EQ(large.choices[i].k2_error * 0x1p20f, one.choices[i].k2_error);
}

TEST(PointChoicesTest, PointsWithoutCurvatureHaveNoChoice) {
  TestPoints points = NoisySphere(5'000, 0.01);
  points.Add(std::nan(""), 0.0, 0.0, 0.0, 0.0, 1.0);
  for (const TestPoints& cloud : {points, NoisySphere(8, 0.01)}) {
    const EstimationResult result = MustEstimate(cloud.ToCloud(), WithChoice(Automatic()));
    ASSERT_EQ(result.choices.size(), cloud.size());
    EXPECT_NE(result.field.points[cloud.size() - 1].status, PointStatus::kOk);
    const PointChoice& choice = result.choices[cloud.size() - 1];
    EXPECT_TRUE(std::isnan(choice.mean_error) && std::isnan(choice.k1_error) && std::isnan(choice.neighbor_count) &&
                std::isnan(choice.jet_weight));
  }
}

TEST(PointChoicesTest, SmallCloudsHaveNoMadeUpErrors) {
  for (const size_t points : {16, 17, 40, 64, 200}) {
    const EstimationResult result = MustEstimate(Sphere(points, 1.0).ToCloud(), WithChoice(Automatic()));
    for (const PointChoice& choice : result.choices.span()) {
      EXPECT_TRUE(std::isnan(choice.mean_error) || choice.mean_error > 0.0f) << points;
    }
  }
}

TEST(PointChoicesTest, ChoicesOfWhatNobodyCanJudgeAreRefused) {
  const auto refused = [](EstimatorOptions options, const std::string& words) {
    options.returns_choice = true;
    const absl::Status status = options.Validate();
    return KindOf(status) == ErrorKind::kInvalid && status.message().find(words) != std::string::npos;
  };
  EXPECT_TRUE(WithChoice({}).Validate().ok());
  EXPECT_TRUE(refused({.neighborhood = NeighborRadius{1.0}}, "radius"));
  EXPECT_TRUE(refused({.neighborhood = NeighborCount{15}}, "neighbor_count is 15"));
  EXPECT_TRUE(refused({.neighborhood = NeighborCount{2049}}, "neighbor_count is 2049"));
  EXPECT_TRUE(refused({.estimator = "delaunay"}, "estimator is delaunay"));
  EXPECT_TRUE(refused({.estimator = "jet"}, "jet_degree is 2"));
}

}  // namespace
}  // namespace curvd::testing
