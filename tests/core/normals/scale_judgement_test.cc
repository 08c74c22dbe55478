#include "core/normals/scale_judgement.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <variant>
#include <vector>

#include "core/normals/sample_view.h"
#include "tests/core/normals/made_samples.h"

namespace curvd::testing {
namespace {

constexpr double kSigma = 1e-3;

SampleTable EvenSample(const SpatialIndex& index) {
  return PlaneSample(index, [](size_t) { return kSigma; });
}

uint32_t NeighborsOf(const ChosenFit& chosen) { return std::get<NeighborCount>(chosen.fit.neighborhood).count; }

TEST(ScaleJudgementTest, CandidatesThatAreMostlyMixedAreNotUsable) {
  const SpatialIndex index = SampledIndex();
  const SampleTable table = EvenSample(index);
  EXPECT_EQ(UsableCandidates(SampleView(table), kSigma), std::vector<bool>(kMadeCandidates, true));
  std::vector<SampleView::Part> parts(kMadeCandidates * table.sample_count(), SampleView::Part::kOwn);
  const size_t most = table.sample_count() / 2 + 1;
  for (size_t i = 0; i < most; ++i) parts[5 * table.sample_count() + i] = SampleView::Part::kMixed;
  std::vector<bool> expected(kMadeCandidates, true);
  expected[5] = false;
  EXPECT_EQ(UsableCandidates(SampleView(table, std::move(parts), 1.0, {}), kSigma), expected);
}

TEST(ScaleJudgementTest, APartHasAThirdOfItsPointsAsNeighborsAtMost) {
  const SpatialIndex index = SampledIndex();
  const SampleTable table = EvenSample(index);
  const double share = 3.0 * 100.0 / static_cast<double>(index.point_count());
  const SampleView small(table, {}, share, {});
  const std::vector<bool> usable = UsableCandidates(small, kSigma);
  for (size_t c = 0; c < kMadeCandidates; ++c) EXPECT_EQ(usable[c], table.candidates()[c].count() <= 100) << c;
  EXPECT_EQ(NeighborsOf(ChooseOne(small, NormalAim::kCurvature, NormalFit())), 96u);
}

// Of a plane, noise is all that normals err by, and the largest neighborhoods have the least of it.
TEST(ScaleJudgementTest, NoiseAsksForManyNeighbors) {
  const SpatialIndex index = SampledIndex();
  const SampleTable table = EvenSample(index);
  const SampleView all(table);
  const ChosenFit chosen = ChooseOne(all, NormalAim::kCurvature, NormalFit());
  EXPECT_EQ(NeighborsOf(chosen), 192u);
  const double sigma = std::ldexp(*chosen.sigma, index.scale_exponent());
  EXPECT_EQ(chosen.squared_error, NoiseOf(all, kMadeCandidates - 1, sigma));
}

TEST(ScaleJudgementTest, NoiseOfAnyCountIsThatOfTheNearestCandidate) {
  const SpatialIndex index = SampledIndex();
  const SampleTable table = EvenSample(index);
  const SampleView all(table);
  const double of_192 = *NoiseOfFit(all, NormalMethod::kJet2, 192);
  EXPECT_NEAR(*NoiseOfFit(all, NormalMethod::kJet2, 384), of_192 / 4.0, 1e-9 * of_192);
  EXPECT_EQ(*NoiseOfFit(all, NormalMethod::kPca, 192), of_192);
  EXPECT_FALSE(NoiseOfFit(all, NormalMethod::kJet4, 192).has_value());
}

// Normals that turn as neighborhoods grow, by more than noise makes them, are those of bends.
TEST(ScaleJudgementTest, BendsCountThreeTimesWhereCurvatureIsMadeOfTheNormals) {
  const SpatialIndex index = SampledIndex();
  SampleTable table = EvenSample(index);
  const std::array<float, 3> turned = {0.6f, 0.0f, 0.8f};
  const size_t last = kMadeCandidates - 1;
  for (size_t i = 0; i < table.sample_count(); ++i) table.outcome(last, i).normal = turned;
  const SampleView all(table);
  const std::vector<bool> usable(kMadeCandidates, true);
  const double noise = NoiseOf(all, last, kSigma);
  const double normals = ErrorOf(all, NormalAim::kNormals, last, kSigma, usable) - noise;
  const double curvature = ErrorOf(all, NormalAim::kCurvature, last, kSigma, usable) - noise;
  EXPECT_GT(normals, 0.0);
  EXPECT_NEAR(curvature, 3.0 * normals, 1e-9 * curvature);
  EXPECT_LT(NeighborsOf(ChooseOne(all, NormalAim::kCurvature, NormalFit())), 192u);
}

TEST(ScaleJudgementTest, WhereNothingTellsTheFallbackIsTaken) {
  const SpatialIndex index = SampledIndex();
  NormalFit fallback;
  fallback.neighborhood = NeighborCount{24};
  const SampleTable empty(index, {0, 1}, {});
  const ChosenFit chosen = ChooseOne(SampleView(empty), NormalAim::kNormals, fallback);
  EXPECT_EQ(NeighborsOf(chosen), 24u);
  EXPECT_FALSE(chosen.sigma.has_value());
  EXPECT_TRUE(std::isinf(chosen.squared_error));
}

}  // namespace
}  // namespace curvd::testing
