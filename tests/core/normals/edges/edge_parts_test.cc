// Clouds of solids whose edges would make the scale of all normals small.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "core/normals/edges/edge_fits.h"
#include "core/normals/normal_fit.h"
#include "core/normals/normal_pilot.h"
#include "core/normals/runs/half_normals.h"
#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

constexpr size_t kSolidPoints = 10'000;
constexpr double kHeight = 1.5;
// Of the points of a block that has so many, of 2 x 2 x kHeight.
const double kBlockSpacing = std::sqrt((8.0 + 8.0 * kHeight) / kSolidPoints);

TestPoints NoisyBlock(double noise_in_spacings, uint64_t seed) {
  TestPoints block = ClosedPlate(kSolidPoints, kHeight, seed);
  AddNoise(noise_in_spacings * kBlockSpacing, seed + 1, block);
  return block;
}

// From each point to the nearest edge, in spacings: the second least distance from a face. The block is wherever it is.
std::vector<double> EdgeDistances(const TestPoints& block) {
  float lo[3], hi[3];
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto less = [axis](const auto& a, const auto& b) { return a[axis] < b[axis]; };
    const auto [least, most] = std::minmax_element(block.positions.begin(), block.positions.end(), less);
    lo[axis] = (*least)[axis], hi[axis] = (*most)[axis];
  }
  std::vector<double> distances;
  for (const auto& position : block.positions) {
    double from_face[3];
    for (size_t axis = 0; axis < 3; ++axis) {
      from_face[axis] = std::min(position[axis] - lo[axis], hi[axis] - position[axis]) / kBlockSpacing;
    }
    std::sort(from_face, from_face + 3);
    distances.push_back(from_face[1]);
  }
  return distances;
}

// Mean angle in degrees over the points at such distances from edges.
double AngleAt(const NormalField& normals, const TestPoints& block, double least, double most) {
  const std::vector<double> distances = EdgeDistances(block);
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < distances.size(); ++i) {
    if (distances[i] < least || distances[i] > most) continue;
    const auto &a = normals[i].normal, &b = block.normals[i];
    const double dot =
        static_cast<double>(a[0]) * b[0] + static_cast<double>(a[1]) * b[1] + static_cast<double>(a[2]) * b[2];
    sum += std::acos(std::min(std::abs(dot), 1.0)) * 180.0 / 3.14159265358979;
    count += 1.0;
  }
  return sum / count;
}

ChosenFit ChosenFor(const SpatialIndex& index, std::optional<NormalMethod> method = std::nullopt) {
  NormalPilot pilot(index, method, 10'000, 1, NormalAim::kCurvature);
  const std::atomic<bool> stopped = false;
  for (size_t block = 0; block < pilot.block_count(); ++block) EXPECT_TRUE(pilot.RunBlock(block, 0, stopped).ok());
  return pilot.Choose();
}

TEST(EdgePartsTest, FacesHaveTheErrorOfManyNeighbors) {
  for (const double noise : {0.05, 0.2}) {
    const TestPoints block = NoisyBlock(noise, 1);
    const NormalResult chosen = MustMakeNormals(BareCloud(block), Estimated());
    EXPECT_GE(chosen.report.neighbor_count, 136u) << noise;
    EXPECT_FALSE(chosen.report.is_doubtful()) << noise;
    // 136 neighbors reach seven spacings far.
    const NormalResult many = MustMakeNormals(BareCloud(block), EstimateBy(NormalMethod::kJet2, 136));
    EXPECT_LT(AngleAt(chosen.normals, block, 9.0, 100.0), 1.1 * AngleAt(many.normals, block, 9.0, 100.0)) << noise;
    const NormalResult few = MustMakeNormals(BareCloud(block), EstimateBy(NormalMethod::kJet2, 24));
    EXPECT_LT(AngleAt(chosen.normals, block, 6.0, 100.0), 0.4 * AngleAt(few.normals, block, 6.0, 100.0)) << noise;
  }
}

TEST(EdgePartsTest, PointsBesideEdgesHaveFewNeighbors) {
  const TestPoints block = NoisyBlock(0.1, 1);
  const NormalResult chosen = MustMakeNormals(BareCloud(block), Estimated());
  for (const uint32_t count : {24, 136}) {
    const NormalResult fixed = MustMakeNormals(BareCloud(block), EstimateBy(NormalMethod::kJet2, count));
    EXPECT_LT(AngleAt(chosen.normals, block, 1.0, 4.0), AngleAt(fixed.normals, block, 1.0, 4.0)) << count;
  }
}

TEST(EdgePartsTest, SmoothSurfacesHaveNone) {
  for (const double noise : {0.02, 0.1, 0.3}) {
    TestPoints torus = Torus(kSolidPoints, 1), sphere = Sphere(kSolidPoints, 1.0);
    AddNoise(noise * 0.218, 2, torus);
    AddNoise(noise * 0.0354, 3, sphere);
    EXPECT_FALSE(ChosenFor(BuildIndex(torus.ToCloud())).fit.edge_part.has_value()) << noise;
    EXPECT_FALSE(ChosenFor(BuildIndex(sphere.ToCloud())).fit.edge_part.has_value()) << noise;
  }
}

// What leaves much of few neighbors, and as much of many, is noise.
TEST(EdgePartsTest, NoiseThatDiffersFromPlaceToPlaceIsNoEdge) {
  TestPoints torus = Torus(kSolidPoints, 1), noisy = torus;
  AddNoise(0.1 * 0.218, 2, torus);
  AddNoise(0.22 * 0.218, 3, noisy);
  for (size_t i = 0; i < kSolidPoints; ++i) {
    if (torus.positions[i][0] > 1.0f) torus.positions[i] = noisy.positions[i];
  }
  EXPECT_FALSE(ChosenFor(BuildIndex(torus.ToCloud())).fit.edge_part.has_value());
}

TEST(EdgePartsTest, AMethodThatTheCallerNamesHasNone) {
  const SpatialIndex index = BuildIndex(NoisyBlock(0.1, 1).ToCloud());
  EXPECT_TRUE(ChosenFor(index).fit.edge_part.has_value());
  EXPECT_FALSE(ChosenFor(index, NormalMethod::kJet4).fit.edge_part.has_value());
}

NormalFit FitWithEdges(const SpatialIndex& index) {
  NormalFit fit;
  fit.neighborhood = NeighborCount{192};
  const double sigma = std::ldexp(0.1 * kBlockSpacing, index.scale_exponent());
  fit.edge_part = EdgePart{.neighborhood = NeighborCount{12}, .variance = sigma * sigma};
  return fit;
}

TEST(EdgePartsTest, EachPointHasTheFirstFitThatIsClear) {
  const TestPoints block = NoisyBlock(0.1, 1);
  SpatialIndex index = BuildIndex(block.ToCloud());
  const PlacedNormals made = MakeByPlace(index, FitWithEdges(index));
  std::vector<size_t> as;
  for (const uint32_t count : {192, 96, 48, 24, 12}) {
    NormalFit fit;
    fit.neighborhood = NeighborCount{count};
    const PlacedNormals of_rung = MakeByPlace(index, fit);
    as.push_back(0);
    for (size_t place = 0; place < index.point_count(); ++place) {
      as.back() += made.normals[place] == of_rung.normals[place] && made.residuals[place] == of_rung.residuals[place];
    }
    // Of 100 points a few lie near an edge whose neighborhoods do not.
    EXPECT_GT(as.back(), kSolidPoints / 100) << count;
  }
  size_t all = 0;
  for (const size_t count : as) all += count;
  EXPECT_EQ(all, index.point_count());
  EXPECT_GT(as.front(), kSolidPoints / 4);
}

TEST(EdgePartsTest, RunsInPartsAreTheSame) {
  const TestPoints block = NoisyBlock(0.1, 1);
  ExpectSameNormalsInParts(block, FitWithEdges(BuildIndex(block.ToCloud())));
}

// Twelve neighbors are too few for halves: points beside edges keep their normals.
TEST(EdgePartsTest, FacesHaveNormalsOfHalves) {
  SpatialIndex index = BuildIndex(NoisyBlock(0.1, 1).ToCloud());
  const NormalFit fit = FitWithEdges(index);
  EXPECT_TRUE(HasHalves(fit, index));
  const PlacedNormals made = MakeByPlace(index, fit);
  MakeHalfNormals(index, fit);
  const size_t same = CountKeptByHalves(index, made);
  EXPECT_GT(same, kSolidPoints / 50);
  EXPECT_LT(same, kSolidPoints / 3);
}

TEST(EdgePartsTest, TheIndexTellsOfEdges) {
  SpatialIndex index = BuildIndex(NoisyBlock(0.1, 1).ToCloud());
  NormalFit fit = FitWithEdges(index);
  MakeByPlace(index, fit);
  EXPECT_TRUE(index.shows_edges());
  fit.edge_part.reset();
  MakeByPlace(index, fit);
  EXPECT_FALSE(index.shows_edges());
}

TEST(EdgePartsTest, ThreadsChangeNothing) {
  const TestPoints block = NoisyBlock(0.2, 1);
  const NormalResult one = MustMakeNormals(BareCloud(block), Estimated(), 1);
  const NormalResult three = MustMakeNormals(BareCloud(block), Estimated(), 3);
  EXPECT_TRUE(SameBytes(one.normals, three.normals));
}

}  // namespace
}  // namespace curvd::testing
