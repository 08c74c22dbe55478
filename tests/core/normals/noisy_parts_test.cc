// Clouds of which a part is noisier than the others.
#include "core/normals/noisy_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/normals/normal_fit.h"
#include "core/normals/runs/half_normals.h"
#include "tests/core/normals/made_samples.h"
#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

constexpr size_t kCloudPoints = 20'000;
// Of the points of a torus that has so many.
constexpr double kSpacing = 0.154;

struct Parts {
  TestPoints both, quiet, noisy;  // the same points, with one noise or the other
  std::vector<bool> is_noisy;
};

// A torus whose points with x above `border` have noise of one standard deviation, and all others of another.
Parts PartlyNoisyTorus(double quiet, double noisy, double border) {
  Parts parts;
  parts.quiet = Torus(kCloudPoints, 1);
  parts.noisy = parts.quiet;
  for (const auto& position : parts.quiet.positions) parts.is_noisy.push_back(position[0] > border);
  AddNoise(quiet, 2, parts.quiet);
  AddNoise(noisy, 3, parts.noisy);
  parts.both = parts.quiet;
  for (size_t i = 0; i < kCloudPoints; ++i) {
    if (parts.is_noisy[i]) parts.both.positions[i] = parts.noisy.positions[i];
  }
  return parts;
}

// Mean angle of one part's points.
double AngleIn(const Parts& parts, bool noisy, const NormalField& normals) {
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < kCloudPoints; ++i) {
    if (parts.is_noisy[i] != noisy) continue;
    const auto &a = normals[i].normal, &b = parts.both.normals[i];
    const double dot = static_cast<double>(a[0]) * b[0] + a[1] * b[1] + a[2] * b[2];
    sum += std::acos(std::min(std::abs(dot), 1.0));
    count += 1.0;
  }
  return sum / count;
}

TEST(NoisyPartsTest, EachPartHasTheErrorThatItHasAlone) {
  for (const auto& [quiet, noisy, border] : {std::array{0.1, 1.0, 4.0}, {0.05, 0.5, 0.0}, {0.0, 0.5, 0.0}}) {
    const Parts parts = PartlyNoisyTorus(quiet * kSpacing, noisy * kSpacing, border);
    const NormalResult both = MustMakeNormals(BareCloud(parts.both), Estimated());
    const NormalResult of_quiet = MustMakeNormals(BareCloud(parts.quiet), Estimated());
    const NormalResult of_noisy = MustMakeNormals(BareCloud(parts.noisy), Estimated());
    EXPECT_LT(AngleIn(parts, true, both.normals), 1.15 * AngleIn(parts, true, of_noisy.normals)) << quiet;
    // Of exact points, those at the border err by noise alone.
    if (quiet > 0.0) {
      EXPECT_LT(AngleIn(parts, false, both.normals), 1.5 * AngleIn(parts, false, of_quiet.normals)) << quiet;
    }
    EXPECT_LT(FlippedShare(both.normals, parts.both), 0.001) << quiet;
    ASSERT_TRUE(both.report.noisy_part.has_value()) << quiet;
    EXPECT_NEAR(*both.report.sigma, quiet * kSpacing, 0.15 * quiet * kSpacing + 1e-5);
    EXPECT_NEAR(*both.report.noisy_part->sigma, noisy * kSpacing, 0.15 * noisy * kSpacing);
    const auto share = std::count(parts.is_noisy.begin(), parts.is_noisy.end(), true) / double{kCloudPoints};
    EXPECT_NEAR(both.report.noisy_part->share, share, 0.1);
    EXPECT_FALSE(of_quiet.report.noisy_part.has_value() || of_noisy.report.noisy_part.has_value());
  }
}

// Noise that grows along x by a factor of a hundred, in which no part has one noise: what the noise explains, and what
// it does not, is told of each group by its own.
TEST(NoisyPartsTest, NoiseThatGrowsIsNotTakenForBends) {
  TestPoints torus = Torus(kCloudPoints, 1);
  const TestPoints exact = torus;
  TestPoints moved = torus;
  AddNoise(1.0, 2, moved);
  for (size_t i = 0; i < kCloudPoints; ++i) {
    const double sigma = 0.3 * kSpacing * std::pow(10.0, (exact.positions[i][0] - 8.0) / 8.0);
    for (size_t axis = 0; axis < 3; ++axis) {
      const double offset = static_cast<double>(moved.positions[i][axis]) - exact.positions[i][axis];
      torus.positions[i][axis] += static_cast<float>(sigma * offset);
    }
  }
  const NormalResult result = MustMakeNormals(BareCloud(torus), Estimated());
  EXPECT_GE(result.report.neighbor_count, 68u);
  EXPECT_LT(MeanAngle(result.normals, exact), 0.5);
}

// Where noisy stripes are narrower than neighborhoods, all points get those of both.
TEST(NoisyPartsTest, NarrowStripesAreNoParts) {
  Parts parts = PartlyNoisyTorus(0.03 * kSpacing, 0.3 * kSpacing, 0.0);
  for (size_t i = 0; i < kCloudPoints; ++i) {
    const bool is_noisy = std::fmod(parts.quiet.positions[i][0] + 8.0, 3.2) < 1.6;
    parts.both.positions[i] = is_noisy ? parts.noisy.positions[i] : parts.quiet.positions[i];
  }
  const NormalResult result = MustMakeNormals(BareCloud(parts.both), Estimated());
  EXPECT_FALSE(result.report.noisy_part.has_value());
  EXPECT_GE(result.report.neighbor_count, 96u);
  const NormalResult of_noisy = MustMakeNormals(BareCloud(parts.noisy), Estimated());
  EXPECT_LT(MeanAngle(result.normals, parts.both), MeanAngle(of_noisy.normals, parts.noisy));
}

// Parts of other kinds: of edges, of bends, of density, and of lines.
TEST(NoisyPartsTest, NothingButNoiseMakesParts) {
  const TestPoints torus = Torus(60'000, 4);
  TestPoints dense_patch;
  for (size_t i = 0; i < torus.size(); ++i) {
    const auto& p = torus.positions[i];
    const bool is_in_patch = p[0] > 6.0f && std::abs(p[1]) < 2.0f && std::abs(p[2]) < 2.0f;
    if (is_in_patch || i % 60 == 0) dense_patch.Add(p[0], p[1], p[2], 0, 0, 1);
  }
  for (const double noise : {0.0, 0.002, 0.01}) {
    const TestPoints saddle = ScannedSaddle(12'000, 8.0, 50.0 * noise, 1);
    for (TestPoints points : {ClosedPlate(12'000, 0.5, 1), Waves(12'000, 0.0, 2), dense_patch, saddle}) {
      AddNoise(noise, 5, points);
      const NormalResult result = MustMakeNormals(BareCloud(points), Estimated());
      EXPECT_FALSE(result.report.noisy_part.has_value()) << noise << " " << points.size();
    }
  }
}

// Where the winding number of noisy clusters varies, other sides of them may fit better than the right ones.
TEST(NoisyPartsTest, NoRepairTurnsPartsOfOneSheet) {
  const Parts parts = PartlyNoisyTorus(0.0, kSpacing, 0.0);
  const NormalResult result = MustMakeNormals(BareCloud(parts.both), Estimated());
  EXPECT_LT(FlippedShare(result.normals, parts.both), 0.001);
  EXPECT_FALSE(result.report.is_doubtful());
}

// Few pairs of neighbors of a small noisy part lie along the sheet, among many of the quiet one.
TEST(NoisyPartsTest, NoRepairTurnsSmallPartsOfOneSheet) {
  for (const size_t middle : {0, 2, 4}) {
    Parts parts = PartlyNoisyTorus(0.1 * kSpacing, 2.5 * kSpacing, 0.0);
    const auto around = parts.quiet.positions[middle];
    for (size_t i = 0; i < kCloudPoints; ++i) {
      const auto& p = parts.quiet.positions[i];
      parts.is_noisy[i] = std::hypot(p[0] - around[0], p[1] - around[1], p[2] - around[2]) < 3.7f;
      parts.both.positions[i] = parts.is_noisy[i] ? parts.noisy.positions[i] : p;
    }
    const NormalResult result = MustMakeNormals(BareCloud(parts.both), Estimated());
    ASSERT_TRUE(result.report.noisy_part.has_value()) << middle;
    EXPECT_LT(FlippedShare(result.normals, parts.both), 0.005) << middle;
    EXPECT_LT(*result.report.torn_share, kMostTornShare) << middle;
  }
}

// Few samples of a small part at an open border tell how it bends.
TEST(NoisyPartsTest, NeighborhoodsAreSmallBesideTheirPart) {
  constexpr size_t kWavePoints = 15'000;
  const double spacing = std::sqrt(1.34 / kWavePoints);
  for (const uint64_t seed : {1, 2, 3}) {
    const TestPoints exact = Waves(kWavePoints, 0.0, seed);
    TestPoints waves = exact, noisy = exact;
    AddNoise(0.1 * spacing, 5, waves);
    AddNoise(spacing, 6, noisy);
    for (size_t i = 0; i < kWavePoints; ++i) {
      if (exact.positions[i][0] > 0.9f) waves.positions[i] = noisy.positions[i];
    }
    const NormalResult result = MustMakeNormals(BareCloud(waves), Estimated());
    ASSERT_TRUE(result.report.noisy_part.has_value()) << seed;
    EXPECT_LE(result.report.noisy_part->neighbor_count, result.report.noisy_part->share * kWavePoints / 3.0) << seed;
  }
}

TEST(NoisyPartsTest, OnePointFarAwayHidesNone) {
  for (const float distance : {1e3f, 1e7f, 1e30f}) {
    Parts parts = PartlyNoisyTorus(0.1 * kSpacing, kSpacing, 0.0);
    parts.both.Add(distance, 0, 0, 1, 0, 0);
    const NormalResult result = MustMakeNormals(BareCloud(parts.both), Estimated());
    ASSERT_TRUE(result.report.noisy_part.has_value()) << distance;
    EXPECT_NEAR(*result.report.sigma, 0.1 * kSpacing, 0.015 * kSpacing) << distance;
  }
}

NormalFit PartedFit(const SpatialIndex& index, double least_variance) {
  const double unit = std::ldexp(1.0, 2 * index.scale_exponent());
  NormalFit fit;
  fit.neighborhood = NeighborCount{96};
  fit.noisy_part = NoisyPart{.neighborhood = NeighborCount{256},
                             .shares = true,
                             .probe_count = 48,
                             .least_variance = least_variance * unit,
                             .quiet_variance = 0.0001 * unit};
  return fit;
}

// Each group gets the one fit or the other, or that of fewer neighbors.
TEST(NoisyPartsTest, GroupsAreFittedAsTheirPartIs) {
  const Parts parts = PartlyNoisyTorus(0.01, 0.1, 2.0);
  SpatialIndex index = BuildIndex(parts.both.ToCloud());
  const NormalFit parted = PartedFit(index, 0.001);
  NormalFit quiet = parted, fewer = parted, noisy = parted;
  quiet.noisy_part.reset(), fewer.noisy_part.reset(), noisy.noisy_part.reset();
  fewer.neighborhood = NeighborCount{48};
  noisy.neighborhood = NeighborCount{256};
  noisy.shares = true;
  const PlacedNormals made = MakeByPlace(index, parted), of_quiet = MakeByPlace(index, quiet);
  const PlacedNormals of_fewer = MakeByPlace(index, fewer), of_noisy = MakeByPlace(index, noisy);
  size_t as_quiet = 0, as_fewer = 0, as_noisy = 0;
  for (size_t place = 0; place < index.point_count(); ++place) {
    as_quiet += made.normals[place] == of_quiet.normals[place] ? 1 : 0;
    as_fewer += made.normals[place] == of_fewer.normals[place] ? 1 : 0;
    as_noisy += made.normals[place] == of_noisy.normals[place] ? 1 : 0;
  }
  EXPECT_EQ(as_quiet + as_fewer + as_noisy, index.point_count());
  EXPECT_GT(as_quiet, kCloudPoints / 2);
  EXPECT_GT(as_noisy, kCloudPoints / 4);
  EXPECT_GT(as_fewer, 0u);
}

TEST(NoisyPartsTest, RunsInPartsAreTheSame) {
  const Parts parts = PartlyNoisyTorus(0.01, 0.1, 2.0);
  ExpectSameNormalsInParts(parts.both, PartedFit(BuildIndex(parts.both.ToCloud()), 0.001));
}

// A part whose fits take too few neighbors for halves keeps its normals.
TEST(NoisyPartsTest, HalvesAreThoseOfThePartThatHasThem) {
  const Parts parts = PartlyNoisyTorus(0.01, 0.1, 2.0);
  SpatialIndex index = BuildIndex(parts.both.ToCloud());
  NormalFit fit = PartedFit(index, 0.001);
  fit.method = NormalMethod::kJet4;
  fit.neighborhood = NeighborCount{24};
  EXPECT_TRUE(HasHalves(fit, index));
  const PlacedNormals made = MakeByPlace(index, fit);
  MakeHalfNormals(index, fit);
  const size_t same = CountKeptByHalves(index, made);
  EXPECT_GT(same, kCloudPoints / 2);
  EXPECT_LT(same, kCloudPoints * 3 / 4);
  fit.noisy_part.reset();
  EXPECT_FALSE(HasHalves(fit, index));
}

TEST(NoisyPartsTest, ThreadsChangeNothing) {
  const Parts parts = PartlyNoisyTorus(0.01, 0.1, 2.0);
  const NormalResult one = MustMakeNormals(BareCloud(parts.both), Estimated(), 1);
  const NormalResult three = MustMakeNormals(BareCloud(parts.both), Estimated(), 3);
  EXPECT_TRUE(one.report.noisy_part.has_value());
  EXPECT_TRUE(SameBytes(one.normals, three.normals));
}

TEST(NoisyPartsTest, SamplesOfTwoNoisesHaveTwoParts) {
  const SpatialIndex index = SampledIndex();
  const auto is_noisy = [](size_t group) { return group % 4 == 0; };
  SampleTable table = PlaneSample(index, [&](size_t group) { return is_noisy(group) ? 4e-3 : 1e-3; });
  // The largest neighborhoods of one quiet group reach into the noise.
  constexpr size_t kMixedGroup = 5, kLargest = kMadeCandidates - 1;
  for (size_t i = 0; i < SampleTable::kPointsPerGroup; ++i) {
    table.outcome(kLargest, kMixedGroup * SampleTable::kPointsPerGroup + i).mean_square = 1e-5f;
  }
  const std::optional<SampleParts> parts = FindParts(table);
  ASSERT_TRUE(parts.has_value());
  EXPECT_EQ(parts->noisy_share, 0.25);
  const SampleView noisy = ViewOf(table, *parts, true), quiet = ViewOf(table, *parts, false);
  EXPECT_EQ(noisy.share(), 0.25);
  EXPECT_EQ(quiet.share(), 0.75);
  for (size_t group = 0; group < table.groups().size(); ++group) {
    EXPECT_EQ(parts->is_noisy[group], is_noisy(group)) << group;
    const size_t sample = group * SampleTable::kPointsPerGroup;
    EXPECT_EQ(noisy.Counts(kLargest, sample), is_noisy(group)) << group;
    EXPECT_EQ(quiet.Counts(kLargest, sample), !is_noisy(group) && group != kMixedGroup) << group;
    EXPECT_EQ(quiet.Counts(0, sample), !is_noisy(group)) << group;
  }
  EXPECT_EQ(quiet.part(kLargest, kMixedGroup * SampleTable::kPointsPerGroup), SampleView::Part::kMixed);
}

TEST(NoisyPartsTest, SamplesOfOneNoiseHaveNone) {
  const SpatialIndex index = SampledIndex();
  EXPECT_FALSE(FindParts(PlaneSample(index, [](size_t) { return 1e-3; })).has_value());
}

}  // namespace
}  // namespace curvd::testing
