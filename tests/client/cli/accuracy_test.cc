#include "client/cli/accuracy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace curv {
namespace {

using ::testing::HasSubstr;

PointTable Result() {
  PointTable table;
  table.Set({"mean_curvature", std::vector<float>{1, 2, NAN, 9}});
  table.Set({"true_mean", std::vector<float>{1.5, 1, 0, 0}});
  table.Set({"status", std::vector<uint8_t>{1, 1, 1, 3}});
  return table;
}

TEST(AccuracyTest, ComparesWhatIsOkAndFinite) {
  const absl::StatusOr<Accuracy> accuracy = MeasureAccuracy(Result());
  ASSERT_TRUE(accuracy.ok()) << accuracy.status();
  EXPECT_EQ(accuracy->points, 4u);
  EXPECT_EQ(accuracy->compared, 2u);
  ASSERT_EQ(accuracy->errors.size(), 1u);
  EXPECT_DOUBLE_EQ(accuracy->errors[0].mean, 0.75);
  EXPECT_DOUBLE_EQ(accuracy->errors[0].rms, std::sqrt(0.625));
  EXPECT_DOUBLE_EQ(accuracy->errors[0].largest, 1.0);
  EXPECT_FALSE(accuracy->d1_angle.has_value());
}

TEST(AccuracyTest, NothingToCompareIsNaN) {
  PointTable table = Result();
  table.Set({"status", std::vector<uint8_t>{4, 4, 4, 4}});
  const Accuracy accuracy = *MeasureAccuracy(table);
  EXPECT_EQ(accuracy.compared, 0u);
  EXPECT_TRUE(std::isnan(accuracy.errors[0].mean));
  EXPECT_TRUE(std::isnan(accuracy.errors[0].largest));
}

TEST(AccuracyTest, AnglesIgnoreSignsAndUmbilics) {
  PointTable table = Result();
  const auto set = [&](const char* name, std::vector<float> values) { table.Set({name, std::move(values)}); };
  set("d1x", {1, -1, 1, 1});
  set("d1y", {0, 0, 0, 0});
  set("d1z", {0, 0, 0, 0});
  set("true_d1x", {std::sqrt(3.0f) / 2, 1, 0, 0});
  set("true_d1y", {0.5, 0, 1, 1});
  set("true_d1z", {0, 0, 0, 0});
  set("true_k1", {0, 2, 1, 0});
  set("true_k2", {1, 2, 1, 1});
  EXPECT_NEAR(*MeasureAccuracy(table)->d1_angle, 30.0, 1e-5);
}

TEST(AccuracyTest, SaysWhatIsMissing) {
  PointTable table;
  table.Set({"mean_curvature", std::vector<float>{1}});
  EXPECT_THAT(MeasureAccuracy(table).status().message(), HasSubstr("true_mean"));
  PointTable truth;
  truth.Set({"true_mean", std::vector<float>{1}});
  EXPECT_THAT(MeasureAccuracy(truth).status().message(), HasSubstr("curv estimate"));
}

}  // namespace
}  // namespace curv
