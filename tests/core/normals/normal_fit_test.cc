// Normals from positions alone, on each instruction set that this machine has.
#include "core/normals/normal_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <utility>

#include "tests/core/instruction_sets.h"
#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

using NormalFitTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, NormalFitTest, InstructionSets(), InstructionSetName);

constexpr NormalMethod kMethods[] = {NormalMethod::kPca, NormalMethod::kJet1, NormalMethod::kJet2, NormalMethod::kJet4};

size_t CountOf(const NormalResult& result, PointStatus status) {
  return result.report.status_counts[static_cast<size_t>(status)];
}

TEST_P(NormalFitTest, HigherDegreesAreMoreExactOnCleanSurfaces) {
  const TestPoints torus = Torus(20'000, 1);
  // Degrees, measured with some room above.
  const double most[] = {1.2, 1.2, 0.2, 0.01};
  for (size_t m = 0; m < 4; ++m) {
    const NormalResult result = MustMakeNormals(BareCloud(torus), EstimateBy(kMethods[m], 24));
    EXPECT_EQ(CountOf(result, PointStatus::kOk), torus.size());
    EXPECT_LT(MeanAngle(result.normals, torus), most[m]) << NormalMethodName(kMethods[m]);
  }
}

// Some of the given normals are far from the new ones: those take the side of the others in their leaf.
TEST_P(NormalFitTest, RefitsKeepTheSides) {
  TestPoints torus = Torus(3000, 2);
  const TestPoints exact = torus;
  AddNoise(0.02, 3, torus);
  constexpr size_t kFar = 7;
  for (size_t i = 0; i < torus.size(); ++i) {
    if (i % kFar != 0) continue;
    auto& n = torus.normals[i];
    const float length = std::hypot(n[0], n[1]);
    n = {-0.1f * n[0] - n[1] / length, -0.1f * n[1] + n[0] / length, -0.1f * n[2]};
  }
  SpatialIndex index = BuildIndex(torus.ToCloud());
  RefitNormals(index, {.method = NormalMethod::kJet2, .neighborhood = NeighborCount{48}});
  for (size_t place = 0; place < index.point_count(); ++place) {
    const size_t leaf = place / SpatialIndex::kLeafSize, lane = place % SpatialIndex::kLeafSize;
    const auto& n = exact.normals[index.point_set().slot_of(index.positions(leaf).id[lane])];
    const SpatialIndex::LeafNormals& made = index.half_normals(leaf);
    ASSERT_GT(n[0] * made.x[lane] + n[1] * made.y[lane] + n[2] * made.z[lane], 0.9f) << place;
  }
}

// A run that leaves the rest of a group to others makes the same ones, since it writes none of those that it reads.
TEST_P(NormalFitTest, RefitsInPartsAreTheSame) {
  TestPoints torus = Torus(3000, 2);
  AddNoise(0.5, 3, torus);
  for (size_t i = 0; i < torus.size(); i += 2) std::swap(torus.normals[i][0], torus.normals[i][2]);
  SpatialIndex whole = BuildIndex(torus.ToCloud()), parts = BuildIndex(torus.ToCloud());
  const NormalFit fit{.method = NormalMethod::kJet2, .neighborhood = NeighborCount{24}};
  RefitNormals(whole, fit);
  RefitNormals(parts, fit, 1);
  for (size_t leaf = 0; leaf < whole.leaf_count(); ++leaf) {
    ASSERT_EQ(std::memcmp(&whole.half_normals(leaf), &parts.half_normals(leaf), sizeof(SpatialIndex::LeafNormals)), 0);
  }
}

TEST_P(NormalFitTest, NormalsAreOfUnitLength) {
  for (const NormalMethod method : kMethods) {
    const NormalResult result = MustMakeNormals(BareCloud(Torus(3000, 2)), EstimateBy(method, 30));
    for (size_t i = 0; i < result.normals.size(); ++i) {
      const auto& n = result.normals[i].normal;
      ASSERT_NEAR(std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), 1.0, 1e-6);
    }
  }
}

TEST_P(NormalFitTest, PlanesAreExactAndHaveNoResidual) {
  TestPoints plane = RandomPoints(Layout::kCoplanar, 3000, 1);
  for (auto& normal : plane.normals) normal = {0, 0, 1};
  for (const NormalMethod method : kMethods) {
    const NormalResult result = MustMakeNormals(BareCloud(plane), EstimateBy(method, 24));
    for (size_t i = 0; i < plane.size(); ++i) {
      ASSERT_EQ(result.normals[i].status, PointStatus::kOk);
      ASSERT_EQ(std::abs(result.normals[i].normal[2]), 1.0f);
      // Doubles, of coordinates that are floats: 1e-16 under the root.
      ASSERT_LT(result.normals[i].residual, 1e-7f);
      ASSERT_LT(result.normals[i].variance_ratio, 1e-14f);
    }
  }
}

TEST_P(NormalFitTest, TheResidualIsThatOfTheNoise) {
  TestPoints plane = RandomPoints(Layout::kCoplanar, 20'000, 1);
  constexpr double kSigma = 0.002;
  AddNoise(kSigma, 3, plane);
  NormalOptions options = EstimateBy(NormalMethod::kJet1, 0);
  options.neighborhood = NeighborRadius{0.05};  // about 150 neighbors
  const NormalResult result = MustMakeNormals(BareCloud(plane), options);
  double sum = 0.0;
  for (size_t i = 0; i < plane.size(); ++i) sum += result.normals[i].residual;
  // Over the distance of the farthest neighbor, which is near the radius; 3 coefficients of 150 are fitted.
  EXPECT_NEAR(sum / static_cast<double>(plane.size()), kSigma / 0.05, 0.02 * kSigma / 0.05);
}

TEST_P(NormalFitTest, InstructionSetsAgree) {
  TestPoints torus = Torus(3000, 4);
  AddNoise(0.02, 5, torus);
  for (const NormalMethod method : kMethods) {
    const NormalResult here = MustMakeNormals(BareCloud(torus), EstimateBy(method, 30));
    hwy::SetSupportedTargetsForTest(0);
    const NormalResult best = MustMakeNormals(BareCloud(torus), EstimateBy(method, 30));
    hwy::SetSupportedTargetsForTest(GetParam());
    for (size_t i = 0; i < torus.size(); ++i) {
      ASSERT_EQ(here.normals[i].status, best.normals[i].status);
      for (size_t axis = 0; axis < 3; ++axis) {
        ASSERT_NEAR(here.normals[i].normal[axis], best.normals[i].normal[axis], 1e-6f) << "point " << i;
      }
    }
  }
}

TEST(NormalStatusTest, LinesCoincidentAndSecludedPointsHaveNone) {
  for (const NormalMethod method : kMethods) {
    TestPoints same, line, sheet = RandomPoints(Layout::kCoplanar, 2000, 7);
    for (int i = 0; i < 2000; ++i) {
      same.Add(1, 2, 3, 0, 0, 1);
      line.Add(0.001 * i, 0.002 * i, 0, 0, 0, 1);
    }
    sheet.Add(0.5, 0.5, 9.0, 0, 0, 1);
    const NormalOptions options = EstimateBy(method, 24);
    EXPECT_EQ(CountOf(MustMakeNormals(BareCloud(same), options), PointStatus::kDegenerateArea), 2000u);
    EXPECT_EQ(CountOf(MustMakeNormals(BareCloud(line), options), PointStatus::kSingularFit), 2000u);
    const NormalResult secluded = MustMakeNormals(BareCloud(sheet), options);
    EXPECT_EQ(CountOf(secluded, PointStatus::kTooFewNeighbors), 1u);
    EXPECT_EQ(secluded.normals[2000].status, PointStatus::kTooFewNeighbors);
    EXPECT_TRUE(std::isnan(secluded.normals[2000].normal[0]));
    EXPECT_TRUE(std::isnan(secluded.normals[2000].residual));
  }
}

TEST(NormalStatusTest, CornersAndBordersOfSheetsHaveNormals) {
  TestPoints wedge;  // its tip has an angle of 6 degrees
  for (int i = 0; i < 20'000; ++i) {
    const double x = std::sqrt((i + 0.5) / 20'000), y = 0.1 * x * (std::fmod(0.6180339887 * i, 1.0) - 0.5);
    wedge.Add(x, y, 0, 0, 0, 1);
  }
  for (const uint32_t count : {8u, 24u, 100u}) {
    const NormalResult result = MustMakeNormals(BareCloud(wedge), EstimateBy(NormalMethod::kPca, count));
    EXPECT_EQ(CountOf(result, PointStatus::kOk), wedge.size()) << count;
  }
}

TEST(NormalStatusTest, FewPointsAreTooFew) {
  for (const size_t points : {size_t{1}, size_t{3}, size_t{23}}) {
    const NormalResult result = MustMakeNormals(BareCloud(Sphere(points, 1.0)), EstimateBy(NormalMethod::kJet2, 24));
    EXPECT_EQ(CountOf(result, PointStatus::kTooFewNeighbors), points);
    EXPECT_TRUE(std::isnan(result.normals[0].normal[2]));
  }
  EXPECT_EQ(CountOf(MustMakeNormals(BareCloud(Sphere(24, 1.0)), EstimateBy(NormalMethod::kJet2, 24)), PointStatus::kOk),
            24u);
}

TEST(NormalStatusTest, InvalidPointsSaySo) {
  TestPoints points = Sphere(500, 1.0);
  points.Add(NAN, 0, 0, 0, 0, 1);
  const NormalResult result = MustMakeNormals(BareCloud(points), EstimateBy(NormalMethod::kJet2, 20));
  EXPECT_EQ(result.normals[500].status, PointStatus::kInvalidInput);
  EXPECT_EQ(CountOf(result, PointStatus::kInvalidInput), 1u);
  EXPECT_EQ(CountOf(result, PointStatus::kOk), 500u);
}

}  // namespace
}  // namespace curvd::testing
