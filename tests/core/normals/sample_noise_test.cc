#include "core/normals/sample_noise.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <utility>
#include <vector>

#include "core/normals/sample_view.h"
#include "tests/core/normals/made_samples.h"

namespace curvd::testing {
namespace {

// Of values that are kept in single precision.
constexpr double kRoundingOfSingles = 1e-6;

constexpr bool IsEven(size_t group) { return group % 2 == 0; }

// The groups whose number is even, or those whose number is odd.
SampleView EveryOther(const SampleTable& table, bool even) {
  std::vector<SampleView::Part> parts;
  for (size_t i = 0; i < table.candidates().size() * table.sample_count(); ++i) {
    const size_t group = i % table.sample_count() / SampleTable::kPointsPerGroup;
    parts.push_back(IsEven(group) == even ? SampleView::Part::kOwn : SampleView::Part::kOther);
  }
  return {table, std::move(parts), 0.5, {}};
}

TEST(SampleNoiseTest, SigmaIsThatOfThePart) {
  const SpatialIndex index = SampledIndex();
  const SampleTable table = PlaneSample(index, [](size_t group) { return IsEven(group) ? 1e-3 : 4e-3; });
  const SampleView even = EveryOther(table, true), odd = EveryOther(table, false);
  EXPECT_NEAR(*SigmaOf(even), 1e-3, 1e-3 * kRoundingOfSingles);
  EXPECT_NEAR(*SigmaOf(odd), 4e-3, 4e-3 * kRoundingOfSingles);
  // One view changes nothing that another one, or the whole, tells.
  EXPECT_NEAR(*SigmaOf(even), 1e-3, 1e-3 * kRoundingOfSingles);
  const double all = *SigmaOf(SampleView(table));
  EXPECT_TRUE(all >= 0.999e-3 && all <= 4.001e-3) << all;
}

TEST(SampleNoiseTest, NothingTellsNothing) {
  const SpatialIndex index = SampledIndex();
  EXPECT_FALSE(SigmaOf(SampleView(SampleTable(index, {0, 1}, {}))).has_value());
  SampleTable table = PlaneSample(index, [](size_t) { return 1e-3; });
  for (size_t c = 0; c < kMadeCandidates; ++c) {
    for (size_t i = 0; i < table.sample_count(); ++i) table.outcome(c, i).is_fitted = false;
  }
  EXPECT_FALSE(SigmaOf(SampleView(table)).has_value());
}

TEST(SampleNoiseTest, NeighborhoodsAreLargeBesideTheNoise) {
  const SpatialIndex index = SampledIndex();
  const SampleTable table = PlaneSample(index, [](size_t) { return 1e-3; });
  const SampleView all(table);
  // Of 48 neighbors the radius is 0.069.
  EXPECT_TRUE(IsLargeEnough(all, 4, 0.069 / 5.1));
  EXPECT_FALSE(IsLargeEnough(all, 4, 0.069 / 4.9));
}

TEST(SampleNoiseTest, LinesLeaveSmallScalesUndetermined) {
  const SpatialIndex index = SampledIndex();
  SampleTable table = PlaneSample(index, [](size_t) { return 1e-3; });
  EXPECT_FALSE(SeesLines(SampleView(table), 1e-3));
  for (size_t i = 0; i < table.sample_count(); ++i) table.outcome(2, i).excess = 1000.0f;
  const SampleView all(table);
  EXPECT_FALSE(IsMostlyDetermined(all, 2));
  EXPECT_TRUE(IsMostlyDetermined(all, 3));
  EXPECT_TRUE(CrossesTooFew(all, 2, 1e-3));
  EXPECT_FALSE(CrossesTooFew(all, 3, 1e-3));
  EXPECT_TRUE(SeesLines(all, 1e-3));
}

// In strips, and along wires, larger scales are no better.
TEST(SampleNoiseTest, TheLargestScalesAreNotThoseOfLines) {
  const SpatialIndex index = SampledIndex();
  SampleTable table = PlaneSample(index, [](size_t) { return 1e-3; });
  for (size_t c = 2; c < kMadeCandidates; ++c) {
    for (size_t i = 0; i < table.sample_count(); ++i) table.outcome(c, i).excess = 1000.0f;
  }
  EXPECT_FALSE(SeesLines(SampleView(table), 1e-3));
}

}  // namespace
}  // namespace curvd::testing
