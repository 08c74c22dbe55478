// Normals that are made of one half of the cloud each, on each instruction set that this machine has.
#include "core/normals/runs/half_normals.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "core/base/halves.h"
#include "tests/core/instruction_sets.h"
#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

using HalfNormalsTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, HalfNormalsTest, InstructionSets(), InstructionSetName);

NormalFit ByRadius(double radius) {
  NormalFit fit;
  fit.method = NormalMethod::kJet2;
  fit.neighborhood = NeighborRadius{radius};
  return fit;
}

NormalFit ByCount(NormalMethod method, uint32_t count, bool shares = false) {
  NormalFit fit;
  fit.method = method;
  fit.neighborhood = NeighborCount{count};
  fit.shares = shares;
  return fit;
}

std::array<float, 3> HalfNormalOf(const SpatialIndex& index, size_t place) {
  const SpatialIndex::LeafNormals& n = index.half_normals(place / SpatialIndex::kLeafSize);
  const size_t lane = place % SpatialIndex::kLeafSize;
  return {n.x[lane], n.y[lane], n.z[lane]};
}

int32_t IdOf(const SpatialIndex& index, size_t place) {
  return index.positions(place / SpatialIndex::kLeafSize).id[place % SpatialIndex::kLeafSize];
}

// Of all neighbors within a radius, those of the other half have no part in it, wherever they lie.
TEST_P(HalfNormalsTest, AreMadeOfTheirOwnHalf) {
  TestPoints sphere = Sphere(5'000, 1.0);
  AddNoise(0.005, 1, sphere);
  TestPoints moved = sphere;
  AddNoise(0.005, 2, moved);
  // The first points hold the extent, which the index's unit depends on.
  for (size_t i = 0; i < sphere.size(); ++i) {
    if (HalfOf(static_cast<int32_t>(i)) == Half::kEven || i < 6) moved.positions[i] = sphere.positions[i];
  }
  std::vector<std::array<float, 3>> made[2];
  for (const TestPoints* points : {&sphere, &moved}) {
    SpatialIndex index = BuildIndex(points->ToCloud());
    MakeByPlace(index, ByRadius(0.2));
    MakeHalfNormals(index, ByRadius(0.2));
    auto& normals = made[points == &moved ? 1 : 0];
    normals.resize(points->size());
    for (size_t place = 0; place < index.point_count(); ++place) {
      normals[static_cast<size_t>(IdOf(index, place))] = HalfNormalOf(index, place);
    }
  }
  size_t changed = 0;
  for (size_t i = 0; i < sphere.size(); ++i) {
    double dot = 0.0;
    for (int axis = 0; axis < 3; ++axis) dot += made[0][i][axis] * made[1][i][axis];
    if (HalfOf(static_cast<int32_t>(i)) == Half::kEven) {
      EXPECT_GT(std::abs(dot), 1.0 - 1e-6) << i;
    } else {
      changed += std::abs(dot) < 1.0 - 1e-6 ? 1 : 0;
    }
  }
  EXPECT_GT(changed, 2'000u);
}

// Noise is independent in both halves, of each twice as large: neighbors of distinct halves err independently, and
// those of one half alike.
TEST_P(HalfNormalsTest, OfDistinctHalvesErrIndependently) {
  for (const bool shares : {false, true}) {
    TestPoints plane = Waves(20'000, 0.0, 1);
    for (auto& position : plane.positions) position[2] = 0.0f;
    AddNoise(0.002, 3, plane);
    SpatialIndex index = BuildIndex(plane.ToCloud());
    const NormalFit fit = ByCount(NormalMethod::kJet2, 256, shares);
    MakeByPlace(index, fit);
    for (size_t leaf = 0; leaf < index.leaf_count(); ++leaf) {
      SpatialIndex::LeafNormals& n = index.mutable_normals(leaf);
      for (int lane = 0; lane < SpatialIndex::kLeafSize; ++lane) {
        if (n.z[lane] > 0.0f) continue;
        n.x[lane] = -n.x[lane], n.y[lane] = -n.y[lane], n.z[lane] = -n.z[lane];
      }
    }
    MakeHalfNormals(index, fit);
    double squares = 0.0, of_distinct = 0.0, distinct = 0.0, of_same = 0.0, same = 0.0, whole_squares = 0.0;
    for (size_t place = 0; place < index.point_count(); ++place) {
      const auto normal = HalfNormalOf(index, place);
      ASSERT_GT(normal[2], 0.9f);
      squares += normal[0] * normal[0];
      const SpatialIndex::LeafNormals& whole = index.normals(place / SpatialIndex::kLeafSize);
      whole_squares += std::pow(whole.x[place % SpatialIndex::kLeafSize], 2);
      if (place % SpatialIndex::kLeafSize == 0) continue;
      const auto before = HalfNormalOf(index, place - 1);
      const bool is_same = HalfOf(IdOf(index, place)) == HalfOf(IdOf(index, place - 1));
      (is_same ? of_same : of_distinct) += normal[0] * before[0];
      (is_same ? same : distinct) += 1.0;
    }
    const double variance = squares / static_cast<double>(index.point_count());
    EXPECT_NEAR(variance * static_cast<double>(index.point_count()) / whole_squares, 2.0, 0.4) << shares;
    EXPECT_GT(of_same / same, 0.6 * variance) << shares;
    EXPECT_LT(std::abs(of_distinct / distinct), 0.2 * variance) << shares;
  }
}

// Where runs end early, and another takes on the rest of the group, nothing changes.
TEST_P(HalfNormalsTest, DoNotDependOnWhereRunsEnd) {
  TestPoints sphere = Sphere(2'000, 1.0);
  AddNoise(0.01, 4, sphere);
  for (const bool shares : {false, true}) {
    const NormalFit fit = ByCount(NormalMethod::kJet2, 96, shares);
    SpatialIndex whole = BuildIndex(sphere.ToCloud()), in_parts = BuildIndex(sphere.ToCloud());
    MakeByPlace(whole, fit);
    MakeByPlace(in_parts, fit);
    MakeHalfNormals(whole, fit);
    MakeHalfNormals(in_parts, fit, 1);
    for (size_t place = 0; place < whole.point_count(); ++place) {
      EXPECT_EQ(HalfNormalOf(whole, place), HalfNormalOf(in_parts, place)) << place;
    }
  }
}

// A half without enough neighbors leaves the normal as it is, and points without a normal have none.
TEST_P(HalfNormalsTest, AreTheNormalWhereAHalfDeterminesNone) {
  TestPoints sphere = Sphere(500, 1.0);
  AddNoise(0.05, 5, sphere);
  sphere.Add(2.0, 0.0, 0.0, 1.0, 0.0, 0.0);  // by itself
  SpatialIndex index = BuildIndex(sphere.ToCloud());
  const PlacedNormals made = MakeByPlace(index, ByRadius(0.3));  // of about 11 points
  MakeHalfNormals(index, ByRadius(0.3));
  size_t same = 0, others = 0, unknown = 0;
  for (size_t place = 0; place < index.point_count(); ++place) {
    const auto normal = HalfNormalOf(index, place);
    if (made.statuses[place] != PointStatus::kOk) {
      EXPECT_TRUE(std::isnan(normal[0])) << place;
      ++unknown;
      continue;
    }
    EXPECT_NEAR(std::hypot(normal[0], normal[1], normal[2]), 1.0, 1e-5) << place;
    (normal == made.normals[place] ? same : others) += 1;
  }
  EXPECT_GT(same, 100u);
  EXPECT_GT(others, 10u);
  EXPECT_GT(unknown, 0u);
  const uint64_t all_but_few[kPointStatusEnd] = {0, 91, 9}, too_few[kPointStatusEnd] = {0, 89, 11};
  static_assert(static_cast<size_t>(PointStatus::kOk) == 1);
  EXPECT_TRUE(AreHalfNormals(all_but_few));
  EXPECT_FALSE(AreHalfNormals(too_few));
}

TEST(HasHalvesTest, WithFourNeighborsForEachCoefficient) {
  const SpatialIndex index = BuildIndex(Sphere(500, 1.0).ToCloud());
  const auto has_halves = [&](NormalMethod method, uint32_t count) { return HasHalves(ByCount(method, count), index); };
  EXPECT_FALSE(has_halves(NormalMethod::kJet4, 59));
  EXPECT_TRUE(has_halves(NormalMethod::kJet4, 60));
  EXPECT_FALSE(has_halves(NormalMethod::kJet2, 23));
  EXPECT_TRUE(has_halves(NormalMethod::kJet2, 24));
  EXPECT_FALSE(has_halves(NormalMethod::kPca, 11));
  EXPECT_TRUE(has_halves(NormalMethod::kPca, 12));
  EXPECT_TRUE(HasHalves(ByRadius(0.1), index));
  NormalFit rims = ByCount(NormalMethod::kJet2, 48);
  rims.two_sheets = true;
  EXPECT_FALSE(HasHalves(rims, index));
}

// Points at one place share their noise, but may be of distinct halves.
TEST(HasHalvesTest, NotWherePointsComeTwice) {
  TestPoints twice = Sphere(500, 1.0);
  Append(Sphere(500, 1.0), twice);
  EXPECT_FALSE(HasHalves(ByCount(NormalMethod::kJet2, 48), BuildIndex(twice.ToCloud())));
}

}  // namespace
}  // namespace curvd::testing
