#include "core/job/phases/normal_tasks.h"

#include <gtest/gtest.h>

#include <optional>
#include <string_view>

namespace curvd::testing {
namespace {

NormalTasks TasksOf(std::string_view estimator, bool returns_normals) {
  EstimatorOptions estimate;
  estimate.estimator = estimator;
  NormalOptions normals;
  normals.returns_normals = returns_normals;
  return TasksFor(estimate, normals);
}

TEST(NormalTasksTest, AnEstimateHandsOutNormalsIfItsCallerSaysSo) {
  EXPECT_FALSE(TasksOf("jet", false).returns_normals);
  EXPECT_TRUE(TasksOf("jet", true).returns_normals);
  EXPECT_TRUE(TasksFor(std::nullopt, NormalOptions()).returns_normals);
}

TEST(NormalTasksTest, TheChoiceComparesHalvesAndMakesFitsAnew) {
  EXPECT_TRUE(TasksOf("auto", false).makes_halves);
  EXPECT_TRUE(TasksOf("auto", false).makes_fits_anew);
  EXPECT_FALSE(TasksOf("jet", false).makes_halves);
  EXPECT_FALSE(TasksOf("jet", false).makes_fits_anew);
  EXPECT_FALSE(TasksFor(std::nullopt, NormalOptions()).makes_halves);
}

}  // namespace
}  // namespace curvd::testing
