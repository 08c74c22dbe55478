// What estimates do where normals point to opposite sides of one surface, and where they are opposed by right.
#include "core/job/phases/seam_phase.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/estimators/strategies.h"
#include "core/job/estimation_job.h"
#include "tests/core/seam_clouds.h"
#include "tests/core/test_clouds.h"

namespace curvd::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Every estimator by its defaults, by few and by many neighbors, and by a radius.
std::vector<EstimatorOptions> AllOptions(double radius) {
  std::vector<EstimatorOptions> all;
  for (const Strategy* strategy : Strategies()) {
    EstimatorOptions options;
    options.estimator = strategy->name;
    all.push_back(options);
    for (const uint32_t count : {15u, 200u}) {
      options.neighborhood = NeighborCount{count};
      all.push_back(options);
    }
    options.neighborhood = NeighborRadius{radius};
    all.push_back(options);
  }
  return all;
}

std::string NameOf(const EstimatorOptions& options) {
  const auto* count = std::get_if<NeighborCount>(&options.neighborhood);
  return std::string(options.estimator) + (count == nullptr ? " by radius" : ", K = " + std::to_string(count->count));
}

uint64_t OpposedIn(const EstimationResult& result) {
  return result.field.status_counts[static_cast<size_t>(PointStatus::kOpposedNormals)];
}

void ExpectNoneOkAcrossSeams(const TestPoints& points, const Flips& flips, double radius,
                             const std::vector<char>& sheets = {}) {
  for (const EstimatorOptions& options : AllOptions(radius)) {
    const EstimationResult result = MustEstimate(points.ToCloud(), options);
    EXPECT_THAT(OkAcrossSeams(points, flips, result.field, sheets), IsEmpty()) << NameOf(options);
    EXPECT_GT(OpposedIn(result), 0u) << NameOf(options);
    EXPECT_GT(result.agreement.opposed_pairs, 0u) << NameOf(options);
  }
}

// Such clouds keep every byte: without a marked point, the phase of the seams has nothing to do.
void ExpectNoSeams(const TestPoints& points, double radius, const std::string& what) {
  for (const EstimatorOptions& options : AllOptions(radius)) {
    // One of each way to look at neighbors; the judge is the same.
    if (options.estimator != "avg-hexagram" && options.estimator != "hexagram" && options.estimator != "jet") continue;
    const EstimationResult result = MustEstimate(points.ToCloud(), options);
    EXPECT_EQ(OpposedIn(result), 0u) << what << ", " << NameOf(options);
    EXPECT_EQ(result.agreement.seam_points, 0u) << what << ", " << NameOf(options);
    EXPECT_EQ(result.agreement.opposed_pairs, 0u) << what << ", " << NameOf(options);
  }
}

constexpr size_t kSeamPoints = 4'000;
constexpr double kRadius = 0.22;  // some 50 neighbors on a unit sphere

TEST(SeamPhaseTest, NoPointIsOkAmongNormalsThatAreFlippedAtRandom) {
  for (const double share : {0.5, 0.1, 0.01}) {
    SCOPED_TRACE(share);
    TestPoints points = Sphere(kSeamPoints, 1.0);
    const Flips flips = FlipAtRandom(share, 1, points);
    ExpectNoneOkAcrossSeams(points, flips, kRadius);
  }
}

TEST(SeamPhaseTest, NoPointIsOkWhoseNeighborhoodCrossesTheRimOfAFlippedHalf) {
  for (const TestPoints& whole :
       {Sphere(kSeamPoints, 1.0), RandomSphere(kSeamPoints, 1.0, 2), RandomTorus(kSeamPoints, 3)}) {
    // Along a plane that splits of the index follow, and along one that none does.
    for (const std::array<float, 3> axis : {std::array{0.0f, 0.0f, 1.0f}, std::array{0.5f, -0.7f, 0.6f}}) {
      TestPoints points = whole;
      const Flips flips = FlipWhere(
          [&](const std::array<float, 3>& p) { return p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2] > 0.0f; },
          points);
      ExpectNoneOkAcrossSeams(points, flips, kRadius);
    }
  }
}

// Opposed normals at one place lie on one sheet, whatever is around them.
TEST(SeamPhaseTest, NoPointIsOkWhoseNeighborhoodHoldsOnePlaceWithOpposedNormals) {
  for (const size_t step : {size_t{1}, size_t{10}, kSeamPoints}) {
    SCOPED_TRACE(step);
    TestPoints points = RandomSphere(kSeamPoints, 1.0, 4);
    for (size_t i = 0; i < kSeamPoints; i += step) {
      const auto p = points.positions[i], n = points.normals[i];
      points.Add(p[0], p[1], p[2], -n[0], -n[1], -n[2]);
    }
    Flips flips(points.size(), 0);
    std::fill(flips.begin() + kSeamPoints, flips.end(), 1);
    ExpectNoneOkAcrossSeams(points, flips, kRadius);
  }
}

TEST(SeamPhaseTest, PointsAwayFromTheSeamKeepTheirResults) {
  TestPoints points = Sphere(kSeamPoints, 1.0);
  const EstimationResult right = MustEstimate(points.ToCloud(), {});
  const Flips flips = FlipWhere([](const std::array<float, 3>& p) { return p[2] > 0.0f; }, points);
  const EstimationResult half = MustEstimate(points.ToCloud(), {});
  size_t kept = 0;
  for (size_t i = 0; i < kSeamPoints; ++i) {
    if (half.field.points[i].status != PointStatus::kOk) continue;
    ++kept;
    // Frames of the other side round differently.
    ASSERT_NEAR(half.field.points[i].mean, (flips[i] != 0 ? -1.0f : 1.0f) * right.field.points[i].mean, 1e-5f);
  }
  // The neighborhoods' radius is 0.22, so a belt of 0.44 is lost of a height of 2.
  EXPECT_NEAR(static_cast<double>(kept) / kSeamPoints, 1.0 - 0.22, 0.02);
  EXPECT_EQ(OpposedIn(half), kSeamPoints - kept);
}

TEST(SeamPhaseTest, FlippedPatchesOfThinPlatesAreSeen) {
  for (const double thickness : {2.0, 4.0}) {
    SCOPED_TRACE(thickness);
    TestPoints points = Plate(kSeamPoints, thickness, 4);
    const Flips flips = FlipWhere(
        [](const std::array<float, 3>& p) { return p[2] > 0.0f && std::hypot(p[0] - 1.0f, p[1] - 1.0f) < 0.4f; },
        points);
    std::vector<char> sheets(points.size());
    for (size_t i = 0; i < points.size(); ++i) sheets[i] = points.positions[i][2] > 0.0f ? 1 : 0;
    ExpectNoneOkAcrossSeams(points, flips, 0.12, sheets);
  }
}

TEST(SeamPhaseTest, NoiseHidesNoSeam) {
  const double spacing = std::sqrt(4.0 * 3.14159 / kSeamPoints);
  for (const double noise : {0.2, 0.5}) {
    SCOPED_TRACE(noise);
    TestPoints points = RandomSphere(kSeamPoints, 1.0, 5);
    AddNoise(noise * spacing, 0.2, 6, points);
    const Flips flips = FlipWhere([](const std::array<float, 3>& p) { return p[0] > 0.3f; }, points);
    ExpectNoneOkAcrossSeams(points, flips, kRadius);
  }
}

TEST(SeamPhaseTest, RightNormalsOfOneSheetAreLeftAlone) {
  for (const double noise : {0.0, 0.1, 0.2}) {
    for (TestPoints points :
         {RandomSphere(kSeamPoints, 1.0, 7), RandomTorus(kSeamPoints, 8), Waves(kSeamPoints, 0.0, 9)}) {
      AddNoise(0.05 * noise, noise, 10, points);
      ExpectNoSeams(points, kRadius, "noise " + std::to_string(noise));
    }
  }
}

TEST(SeamPhaseTest, TheSheetsOfThinPartsAreLeftAlone) {
  for (const double thickness : {2.0, 2.5, 4.0, 8.0}) {
    const std::string what = "thickness " + std::to_string(thickness);
    for (uint64_t seed = 0; seed < 3; ++seed) {
      ExpectNoSeams(Plate(kSeamPoints, thickness, seed), 0.12, "plate, " + what);
      ExpectNoSeams(Plate(kSeamPoints, -thickness, seed), 0.12, "gap, " + what);
      ExpectNoSeams(Shell(kSeamPoints, thickness, seed), 0.25, "shell, " + what);
      // Thinner at its rim than the spacing, so that the sheets of thinner ones touch.
      if (thickness >= 4.0) ExpectNoSeams(Lens(kSeamPoints, thickness, seed), 0.12, "lens, " + what);
    }
  }
}

TEST(SeamPhaseTest, NoiseInNormalsMakesNoSeamOfThinParts) {
  for (const double thickness : {2.0, 3.0}) {
    for (uint64_t seed = 0; seed < 3; ++seed) {
      TestPoints plate = Plate(10'000, thickness, seed), shell = Shell(10'000, thickness, seed);
      AddNoise(0.0, 0.2, seed + 20, plate);
      AddNoise(0.0, 0.2, seed + 30, shell);
      ExpectNoSeams(plate, 0.1, "plate");
      ExpectNoSeams(shell, 0.2, "shell");
    }
  }
}

TEST(SeamPhaseTest, KnifeEdgesAreLeftAlone) {
  for (const double degrees : {10.0, 20.0, 40.0, 60.0, 90.0}) {
    for (uint64_t seed = 0; seed < 3; ++seed) {
      ExpectNoSeams(Wedge(kSeamPoints, degrees, seed), 0.15, std::to_string(degrees) + " degrees");
    }
  }
}

TEST(SeamPhaseTest, NoiseMakesNoSeamOfKnifeEdges) {
  for (const double degrees : {30.0, 45.0, 60.0}) {
    for (uint64_t seed = 0; seed < 3; ++seed) {
      TestPoints wedge = Wedge(kSeamPoints, degrees, seed);
      AddNoise(0.0, 0.1, seed + 40, wedge);
      ExpectNoSeams(wedge, 0.15, std::to_string(degrees) + " degrees");
    }
  }
}

TEST(SeamPhaseTest, SpheresThatTouchAreLeftAlone) {
  for (const size_t count : {kSeamPoints, 10 * kSeamPoints}) {
    for (uint64_t seed = 0; seed < 3; ++seed) {
      TestPoints points = RandomSphere(count, 1.0, seed);
      const TestPoints other = RandomSphere(count, 1.0, seed + 50);
      for (size_t i = 0; i < count; ++i) {
        const auto& p = other.positions[i];
        const auto& n = other.normals[i];
        points.Add(p[0] + 2.0, p[1], p[2], n[0], n[1], n[2]);
      }
      ExpectNoSeams(points, count == kSeamPoints ? 0.2 : 0.07, "spheres of " + std::to_string(count));
    }
  }
}

TEST(SeamPhaseTest, CountsNearPairs) {
  TestPoints points = Sphere(kSeamPoints, 1.0);
  EXPECT_EQ(MustEstimate(points.ToCloud(), {}).agreement.near_pairs, 0u);  // nothing to tell
  FlipAtRandom(0.5, 11, points);
  const NormalsAgreement agreement = MustEstimate(points.ToCloud(), {}).agreement;
  EXPECT_EQ(agreement.near_pairs, 6 * kSeamPoints);
  // Two of three normals agree by chance in half of the cases.
  EXPECT_NEAR(static_cast<double>(agreement.opposed_pairs) / static_cast<double>(agreement.near_pairs), 0.5, 0.03);
  EXPECT_EQ(agreement.seam_points, kSeamPoints);
}

uint64_t FlippedPatchesOf(const TestPoints& points) {
  return MustEstimate(points.ToCloud(), {}).agreement.flipped_patches;
}

TEST(SeamPhaseTest, CountsFlippedPatches) {
  const auto cap = [](double x, double y, double z, double cosine) {
    return [=](const std::array<float, 3>& p) { return p[0] * x + p[1] * y + p[2] * z > cosine; };
  };
  TestPoints points = Sphere(kSeamPoints, 1.0);
  EXPECT_EQ(FlippedPatchesOf(points), 0u);
  FlipWhere(cap(0, 0, 1, 0.9), points);
  EXPECT_EQ(FlippedPatchesOf(points), 1u);
  FlipWhere(cap(0, 0, -1, 0.5), points);
  FlipWhere(cap(1, 0, 0, 0.95), points);
  EXPECT_EQ(FlippedPatchesOf(points), 3u);
  FlipWhere(cap(0, 0, -1, 0.9), points);  // right again, in the midst of a flipped one
  EXPECT_EQ(FlippedPatchesOf(points), 4u);
}

TEST(SeamPhaseTest, SinglePointsAreNoPatchesNorAreSheetsThatAgreeNowhere) {
  TestPoints points = Sphere(kSeamPoints, 1.0);
  FlipAtRandom(0.01, 15, points);
  EXPECT_EQ(FlippedPatchesOf(points), 0u);
  TestPoints plate = Plate(kSeamPoints, 2.0, 16);
  FlipWhere([](const std::array<float, 3>& p) { return p[2] > 0.0f && std::hypot(p[0] - 1.0f, p[1] - 1.0f) < 0.4f; },
            plate);
  EXPECT_EQ(FlippedPatchesOf(plate), 1u);
}

TEST(SeamPhaseTest, ThreadsDoNotChangeTheNumberOfPatches) {
  TestPoints points = RandomSphere(20 * kSeamPoints, 1.0, 17);
  FlipAtRandom(0.45, 18, points);
  const uint64_t patches = MustEstimate(points.ToCloud(), {}, 1).agreement.flipped_patches;
  EXPECT_GT(patches, 0u);
  EXPECT_EQ(MustEstimate(points.ToCloud(), {}, 8).agreement.flipped_patches, patches);
}

TEST(SeamPhaseTest, StatusCountsAreThoseOfTheField) {
  TestPoints points = Sphere(kSeamPoints, 1.0);
  FlipAtRandom(0.2, 12, points);
  for (const EstimatorOptions& options : AllOptions(kRadius)) {
    const EstimationResult result = MustEstimate(points.ToCloud(), options);
    std::array<uint64_t, kPointStatusEnd> counts{};
    for (const PointCurvature& point : result.field.points.span()) ++counts[static_cast<size_t>(point.status)];
    EXPECT_EQ(counts, result.field.status_counts) << NameOf(options);
  }
}

TEST(SeamPhaseTest, PointsAtSeamsHaveNoValuesButTheirRadius) {
  TestPoints points = Sphere(kSeamPoints, 1.0);
  FlipAtRandom(0.5, 13, points);
  EstimatorOptions options;
  for (const bool by_radius : {false, true}) {
    if (by_radius) options.neighborhood = NeighborRadius{kRadius};
    const EstimationResult result = MustEstimate(points.ToCloud(), options);
    ASSERT_EQ(OpposedIn(result), kSeamPoints);
    for (const PointCurvature& point : result.field.points.span()) {
      ASSERT_TRUE(std::isnan(point.mean) && std::isnan(point.gaussian) && std::isnan(point.k1) &&
                  std::isnan(point.d2[2]));
      ASSERT_TRUE(by_radius ? point.radius == static_cast<float>(kRadius) : point.radius > 0.0f);
    }
  }
}

TEST(SeamPhaseTest, RefusesOpposedNormalsWhereTheCallerWantsThat) {
  EstimatorOptions options;
  options.opposed_normals = OpposedNormalsPolicy::kReject;
  TestPoints points = Sphere(kSeamPoints, 1.0);
  WorkerPool pool(2);
  EXPECT_TRUE(EstimateCurvature(points.ToCloud(), options, pool).ok());
  for (float& component : points.normals[1711]) component = -component;
  const auto refused = EstimateCurvature(points.ToCloud(), options, pool);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(KindOf(refused.status()), ErrorKind::kOpposedNormals);
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("opposed to those of neighbors"));
}

TEST(SeamPhaseTest, ThreadsAndUnitsDoNotChangeWhoIsRefused) {
  TestPoints points = RandomSphere(kSeamPoints, 1.0, 14);
  FlipWhere([](const std::array<float, 3>& p) { return p[0] > 0.3f; }, points);
  const EstimationResult one = MustEstimate(points.ToCloud(), {}, 1);
  const EstimationResult many = MustEstimate(points.ToCloud(), {}, 8);
  for (auto& position : points.positions) {
    for (float& coordinate : position) coordinate *= 0x1p-40f;
  }
  const EstimationResult small = MustEstimate(points.ToCloud(), {});
  for (size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(one.field.points[i].status, many.field.points[i].status);
    ASSERT_EQ(one.field.points[i].status, small.field.points[i].status);
  }
}

}  // namespace
}  // namespace curvd::testing
