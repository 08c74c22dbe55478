#include "core/scale/chosen/choice_writer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/scale/automatic_options.h"
#include "core/scale/chosen/chosen_estimates.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

constexpr size_t kWrittenGroup = 3;

// The sampled points of a cloud: how many there are, of which the first so many tell errors. Of a cloud that is too
// small to choose by nothing is judged.
struct SampledPoints {
  size_t all = 24, known = 24;
  bool are_judged = true;
};

// A sphere whose points are the averages of hexagrams of 64 and of 256 neighbors, with the weights 3 and 1. The choices
// of a group of it are written.
class WrittenSphere {
 public:
  explicit WrittenSphere(const SampledPoints& samples = {}) {
    const TestPoints points = Sphere(2000, 1.0);
    index_ = BuildIndex(points.ToCloud());
    results_.resize(index_.point_count());
    choices_.resize(index_.point_count());
    for (size_t i = 0; i < samples.all; ++i) {
      table_.emplace_back(points.positions[i * points.size() / samples.all]);
      if (i < samples.known) AddEstimates(table_.back(), i);
    }
    ScaleChoice choice;
    choice.chosen = {{kHexagramMethod, RungNear(64)}, {kHexagramMethod, RungNear(256)}};
    for (ScaleWeights* const weights : {&choice.weights.mean, &choice.weights.traceless, &choice.weights.gaussian}) {
      weights->cloud_weights = {0.75, 0.25};
    }
    if (samples.are_judged) {
      for (const ScaleCandidate& candidate : choice.chosen)
        choice.scores.push_back({candidate, 1.0, 1.0, 1.0, 0.0, 1.0});
    }
    choice_ = CloudChoice({{table_, choice}});
    const ChosenEstimates estimates(options_, index_, choice_, nullptr, results_.data());
    EXPECT_TRUE(estimates.EstimateGroup(kWrittenGroup, s).ok());
    for (size_t i = 0; i < s.points.size; ++i) ResultAt(i) = ChosenEstimates::Blended(s, i);
  }

  // What the scratch holds may be changed before choices are written.
  AutomaticScratch s;
  SpatialIndex& index() { return index_; }
  PointCurvature& ResultAt(size_t point) { return results_[s.points.slot[point]]; }

  // The choice that is written of a point of the group.
  PointChoice Written(size_t point) {
    const ChoiceWriter writer = StartedWriter();
    writer.Write(point, s);
    return choices_[s.points.slot[point]];
  }
  PointChoice WrittenMended(size_t point) {
    const ChoiceWriter writer = StartedWriter();
    writer.WriteMended(point, s);
    return choices_[s.points.slot[point]];
  }

 private:
  // Of both scales and the next ones, for all neighbors and for halves.
  static void AddEstimates(PilotPoint& sample, size_t i) {
    sample.radius.fill(0.1f);
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      const float moved = i % 2 == 0 ? 0.01f : -0.01f;
      sample.mean[kHexagramMethod][rung] = {1.0f, 1.0f + moved, 1.0f - moved};
      sample.difference[kHexagramMethod][rung] = {0.1f, 0.1f - moved, 0.1f + moved};
      sample.twist[kHexagramMethod][rung] = {0.0f, moved, -moved};
    }
  }
  ChoiceWriter StartedWriter() {
    const ChoiceWriter writer(options_, index_, choice_, results_.data(), choices_.data());
    writer.Start(s);
    return writer;
  }

  const EstimatorOptions options_{.estimator = kAutomaticEstimator, .neighborhood = AutomaticScale{}};
  SpatialIndex index_;
  PilotTable table_;
  CloudChoice choice_;
  std::vector<PointCurvature> results_;
  std::vector<PointChoice> choices_;
};

std::array<float, 3> WrittenErrors(const PointChoice& choice) {
  return {choice.mean_error, choice.k1_error, choice.k2_error};
}

std::array<float, 5> WrittenWeights(const PointChoice& choice) {
  return {choice.neighbor_count, choice.avg_hexagram_weight, choice.normal_regression_weight, choice.jet_weight,
          choice.aso_weight};
}

template <size_t kCount>
bool AllAreNaN(const std::array<float, kCount>& values) {
  return std::all_of(values.begin(), values.end(), [](float value) { return std::isnan(value); });
}

template <size_t kCount>
bool AllArePositive(const std::array<float, kCount>& values) {
  return std::all_of(values.begin(), values.end(), [](float value) { return value > 0.0f; });
}

PointFit FitWithErrors(bool is_by_heights) {
  PointCurvature point{};
  point.status = PointStatus::kOk;
  return {point, 100, 0.5, 1.5, 2.5, is_by_heights};
}

constexpr std::array<float, 3> kErrorsOfFit = {0.5f, 1.5f, 2.5f};
constexpr std::array<float, 5> kHeightsAlone = {100.0f, 0.0f, 0.0f, 1.0f, 0.0f},
                               kNormalsAlone = {100.0f, 0.0f, 1.0f, 0.0f, 0.0f};

TEST(ChoiceWriterTest, AveragesHaveTheErrorsOfTheSamples) {
  WrittenSphere sphere;
  ASSERT_GT(sphere.s.points.size, 10u);
  for (size_t i = 0; i < sphere.s.points.size; ++i) {
    const PointChoice choice = sphere.Written(i);
    EXPECT_TRUE(AllArePositive(WrittenErrors(choice)));
    EXPECT_EQ(WrittenWeights(choice), (std::array{0.75f * 64.0f + 0.25f * 256.0f, 1.0f, 0.0f, 0.0f, 0.0f}));
  }
}

TEST(ChoiceWriterTest, EstimatesThatAPointLacksHaveNoWeight) {
  WrittenSphere sphere;
  sphere.s.shares[5] = {};
  sphere.s.shares[5][1] = 0.25;
  EXPECT_EQ(WrittenWeights(sphere.Written(5)), (std::array{256.0f, 1.0f, 0.0f, 0.0f, 0.0f}));
}

TEST(ChoiceWriterTest, PointsWithoutCurvatureHaveNothing) {
  WrittenSphere sphere;
  sphere.s.own_fits[5] = FitWithErrors(true);
  for (const PointStatus status : {PointStatus::kOutlier, PointStatus::kOpposedNormals, PointStatus::kSingularFit}) {
    sphere.ResultAt(5) = UndefinedCurvature(status);
    const PointChoice choice = sphere.Written(5);
    EXPECT_TRUE(AllAreNaN(WrittenErrors(choice)));
    EXPECT_TRUE(AllAreNaN(WrittenWeights(choice)));
  }
}

TEST(ChoiceWriterTest, OwnFitsHaveTheirOwnErrors) {
  WrittenSphere sphere;
  sphere.s.own_fits[5] = FitWithErrors(true);
  sphere.s.own_fits[6] = FitWithErrors(false);
  EXPECT_EQ(WrittenErrors(sphere.Written(5)), kErrorsOfFit);
  EXPECT_EQ(WrittenWeights(sphere.Written(5)), kHeightsAlone);
  EXPECT_EQ(WrittenErrors(sphere.Written(6)), kErrorsOfFit);
  EXPECT_EQ(WrittenWeights(sphere.Written(6)), kNormalsAlone);
  EXPECT_NE(WrittenErrors(sphere.Written(7)), kErrorsOfFit);
}

// What a fit leaves of normals that were made of positions does not show what these share.
TEST(ChoiceWriterTest, OwnFitsOfNormalsHaveNoErrorsWhereThereAreHalfNormals) {
  WrittenSphere sphere;
  ASSERT_TRUE(sphere.index().MakeHalfNormals().ok());
  sphere.s.own_fits[5] = FitWithErrors(true);
  sphere.s.own_fits[6] = FitWithErrors(false);
  EXPECT_EQ(WrittenErrors(sphere.Written(5)), kErrorsOfFit);
  EXPECT_EQ(WrittenWeights(sphere.Written(5)), kHeightsAlone);
  EXPECT_TRUE(AllAreNaN(WrittenErrors(sphere.Written(6))));
  EXPECT_EQ(WrittenWeights(sphere.Written(6)), kNormalsAlone);
  // Averages have those of the samples, which halves tell.
  EXPECT_TRUE(AllArePositive(WrittenErrors(sphere.Written(7))));
}

TEST(ChoiceWriterTest, OneSidedPointsHaveNothingUnlessTheyHaveAFit) {
  WrittenSphere sphere;
  sphere.s.has_edges = true;
  sphere.s.clear_blends = sphere.s.blends;
  sphere.s.clear_blends[5] = sphere.s.clear_blends[6] = Blend();
  sphere.s.own_fits[6] = FitWithErrors(true);
  EXPECT_TRUE(AllAreNaN(WrittenErrors(sphere.Written(5))));
  EXPECT_TRUE(AllAreNaN(WrittenWeights(sphere.Written(5))));
  EXPECT_EQ(WrittenErrors(sphere.Written(6)), kErrorsOfFit);
  EXPECT_EQ(WrittenWeights(sphere.Written(6)), kHeightsAlone);
  EXPECT_TRUE(AllArePositive(WrittenErrors(sphere.Written(7))));
}

// An average of the estimates that a seam leaves, of which those have so much weight.
PointChoice MendedWith(double weight, bool is_mended = true) {
  WrittenSphere sphere;
  const PointCurvature of_all = sphere.ResultAt(5);
  sphere.s.blends[5] = Blend();
  sphere.s.blends[5].Add(of_all, {weight, weight, weight});
  return is_mended ? sphere.WrittenMended(5) : sphere.Written(5);
}

TEST(ChoiceWriterTest, PointsThatASeamTakesMuchOfTheWeightFromHaveNoErrors) {
  EXPECT_TRUE(AllArePositive(WrittenErrors(MendedWith(1.0))));
  EXPECT_TRUE(AllArePositive(WrittenErrors(MendedWith(0.91))));
  const PointChoice choice = MendedWith(0.89);
  EXPECT_TRUE(AllAreNaN(WrittenErrors(choice)));
  EXPECT_FALSE(AllAreNaN(WrittenWeights(choice)));
  EXPECT_TRUE(AllArePositive(WrittenErrors(MendedWith(0.89, false)))) << "where there is no seam";
}

TEST(ChoiceWriterTest, FewKnownSamplesTellNoErrorsUnlessThereAreNoOthers) {
  for (const auto& [samples, have_errors] : {std::pair{SampledPoints{24, 0}, false},
                                             {SampledPoints{24, 7}, false},
                                             {SampledPoints{24, 8}, true},
                                             {SampledPoints{5, 4}, false},
                                             {SampledPoints{5, 5}, true}}) {
    WrittenSphere sphere(samples);
    const PointChoice choice = sphere.Written(5);
    EXPECT_EQ(AllArePositive(WrittenErrors(choice)), have_errors) << samples.known << " of " << samples.all;
    EXPECT_EQ(AllAreNaN(WrittenErrors(choice)), !have_errors) << samples.known << " of " << samples.all;
    EXPECT_FALSE(AllAreNaN(WrittenWeights(choice))) << samples.known << " of " << samples.all;
  }
}

TEST(ChoiceWriterTest, CloudsThatAreTooSmallToChooseByHaveNoErrors) {
  WrittenSphere sphere({.are_judged = false});
  EXPECT_TRUE(AllAreNaN(WrittenErrors(sphere.Written(5))));
  EXPECT_FALSE(AllAreNaN(WrittenWeights(sphere.Written(5))));
  // A fit of a point's own needs no samples.
  sphere.s.own_fits[5] = FitWithErrors(false);
  EXPECT_EQ(WrittenErrors(sphere.Written(5)), kErrorsOfFit);
}

// More than four times the error is something that the samples do not have.
TEST(ChoiceWriterTest, DoubtsAndSpreadsThatAreFarLargerAreTheErrors) {
  WrittenSphere sphere;
  const std::array<float, 3> errors = WrittenErrors(sphere.Written(5));
  const float most = *std::max_element(errors.begin(), errors.end());
  const float least = *std::min_element(errors.begin(), errors.end());
  sphere.s.doubts[5] = 3.9 * double{least};
  EXPECT_EQ(WrittenErrors(sphere.Written(5)), errors);
  const float doubt = 4.1f * most;
  sphere.s.doubts[5] = doubt;
  EXPECT_EQ(WrittenErrors(sphere.Written(5)), (std::array{doubt, doubt, doubt}));
  // So are estimates that lie far apart, here by 100 in all curvatures but k2 - k1.
  sphere.s.doubts[5] = 0.0;
  PointCurvature other = sphere.ResultAt(5);
  for (float PointCurvature::*const curvature : {&PointCurvature::mean, &PointCurvature::k1, &PointCurvature::k2}) {
    other.*curvature += 100.0f;
  }
  sphere.s.blends[5] = Blend();
  sphere.s.blends[5].Add(sphere.ResultAt(5), {0.5, 0.5, 0.5});
  sphere.s.blends[5].Add(other, {0.5, 0.5, 0.5});
  for (const float error : WrittenErrors(sphere.Written(5))) EXPECT_NEAR(error, 50.0f, 1e-3f);
}

}  // namespace
}  // namespace curvd::testing
