// Fits of several points at once, on each instruction set that this machine has.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "core/normals/fits/fit_group.h"
#include "core/normals/fits/normal_plan.h"
#include "core/normals/fits/normal_scratch.h"
#include "core/normals/normal_fit.h"
#include "tests/core/instruction_sets.h"
#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {
namespace {

using LaneFitsTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, LaneFitsTest, InstructionSets(), InstructionSetName);

constexpr NormalMethod kMethods[] = {NormalMethod::kPca, NormalMethod::kJet1, NormalMethod::kJet2, NormalMethod::kJet4};

// Fits all points of the index. Whoever inspects neighborhoods gets them one by one.
PlacedNormals Fit(const SpatialIndex& index, NormalMethod method, uint32_t count, bool one_by_one) {
  NormalFit fit;
  fit.method = method;
  fit.neighborhood = NeighborCount{count};
  const NormalPlan plan(fit, index);
  const auto scratch = std::make_unique<NormalScratch>();
  if (one_by_one) scratch->inspect = [](size_t) {};
  PlacedNormals made;
  for (size_t group = 0; group < index.group_count(); ++group) {
    EXPECT_TRUE(FitGroup(index, plan, group, GroupSample::kAll, *scratch).ok());
    for (size_t i = 0; i < scratch->points.size; ++i) {
      const GroupDoubleVectors& n = scratch->normal;
      made.normals.push_back({static_cast<float>(n.x[i]), static_cast<float>(n.y[i]), static_cast<float>(n.z[i])});
      made.statuses.push_back(scratch->points.status[i]);
      made.residuals.push_back(static_cast<float>(std::sqrt(scratch->mean_square[i])));
      made.variance_ratios.push_back(static_cast<float>(scratch->variance_ratio[i]));
    }
  }
  return made;
}

// Frames of the same plane may have other axes within it, so that sums and their rounding differ.
TEST_P(LaneFitsTest, AgreesWithFitsOfSinglePoints) {
  TestPoints torus = Torus(3001, 4);  // the last vector is not full
  AddNoise(0.02, 5, torus);
  SpatialIndex index = BuildIndex(torus.ToCloud());
  for (const NormalMethod method : kMethods) {
    const PlacedNormals alone = Fit(index, method, 40, true);
    const PlacedNormals together = Fit(index, method, 40, false);
    EXPECT_EQ(alone.statuses, together.statuses) << NormalMethodName(method);
    for (size_t place = 0; place < torus.size(); ++place) {
      for (size_t axis = 0; axis < 3; ++axis) {
        ASSERT_NEAR(alone.normals[place][axis], together.normals[place][axis], 1e-6f) << place;
      }
      ASSERT_NEAR(alone.residuals[place], together.residuals[place], 1e-6f * alone.residuals[place]);
      ASSERT_NEAR(alone.variance_ratios[place], together.variance_ratios[place], 1e-6f);
    }
  }
}

// Lines, coincident points, volumes without a least axis, points by themselves.
TEST_P(LaneFitsTest, RefusesTheSamePoints) {
  for (const Layout layout : kLayouts) {
    // On a lattice several axes may be the least, of which rounding takes one, and few neighbors decide a jet over one
    // of them and none over another.
    const size_t most = layout == Layout::kLattice ? 10 : 0;
    SpatialIndex index = BuildIndex(RandomPoints(layout, 1000, 6).ToCloud());
    for (const NormalMethod method : kMethods) {
      for (const uint32_t count : {8u, 24u, 64u}) {
        if (count < LeastNeighborCount(method)) continue;
        const PlacedNormals alone = Fit(index, method, count, true);
        const PlacedNormals together = Fit(index, method, count, false);
        size_t different = 0;
        for (size_t i = 0; i < 1000; ++i) different += alone.statuses[i] != together.statuses[i] ? 1 : 0;
        EXPECT_LE(different, most) << LayoutName(layout) << " " << NormalMethodName(method) << " " << count;
      }
    }
  }
}

// A group may be fitted in parts, which bring other points together in a vector.
TEST_P(LaneFitsTest, APointHasTheSameFitWhicheverOthersAreFittedWithIt) {
  TestPoints torus = Torus(2000, 6);
  AddNoise(0.05, 7, torus);
  SpatialIndex index = BuildIndex(torus.ToCloud());
  for (const NormalMethod method : kMethods) {
    NormalFit fit;
    fit.method = method;
    fit.neighborhood = NeighborCount{24};
    const NormalPlan plan(fit, index);
    const auto whole = std::make_unique<NormalScratch>(), rest = std::make_unique<NormalScratch>();
    rest->first_point = 3;
    for (size_t group = 0; group < index.group_count(); ++group) {
      ASSERT_TRUE(FitGroup(index, plan, group, GroupSample::kAll, *whole).ok());
      ASSERT_TRUE(FitGroup(index, plan, group, GroupSample::kAll, *rest).ok());
      for (size_t i = 0; i < rest->points.size; ++i) {
        ASSERT_EQ(rest->points.place[i], whole->points.place[i + 3]);
        ASSERT_EQ(rest->normal.x[i], whole->normal.x[i + 3]) << NormalMethodName(method) << " " << group << " " << i;
        ASSERT_EQ(rest->normal.y[i], whole->normal.y[i + 3]);
        ASSERT_EQ(rest->normal.z[i], whole->normal.z[i + 3]);
        ASSERT_EQ(rest->mean_square[i], whole->mean_square[i + 3]);
        ASSERT_EQ(rest->variance_ratio[i], whole->variance_ratio[i + 3]);
      }
    }
  }
}

}  // namespace
}  // namespace curvd::testing
