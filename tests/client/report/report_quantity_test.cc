#include "client/report/report_quantity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

namespace curv {
namespace {

using ::testing::ElementsAre;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

PointTable Table(size_t size) {
  PointTable table;
  for (const char* name : {"x", "y", "z", "nx"}) table.Set({name, std::vector<float>(size)});
  return table;
}

std::vector<uint32_t> All(const PointTable& table) {
  std::vector<uint32_t> all(table.size());
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

std::vector<std::string> Names(const ReportQuantities& quantities) {
  std::vector<std::string> names;
  for (const ReportQuantity& quantity : quantities.shown) names.push_back(quantity.column);
  return names;
}

TEST(ChooseQuantitiesTest, PutsCurvaturesFirstAndLeavesVectorsAndColorsOut) {
  PointTable table = Table(2);
  for (const char* name : {"intensity", "radius", "k1", "d1x", "red", "mean_curvature", "true_d2z"}) {
    table.Set({name, std::vector<float>(2)});
  }
  table.Set({"status", std::vector<uint8_t>{1, 1}});
  EXPECT_THAT(Names(ChooseQuantities(table, All(table), {.most = 12})),
              ElementsAre("mean_curvature", "k1", "radius", "intensity"));
}

TEST(ChooseQuantitiesTest, NamesWhatItLeavesOutButKeepsWhatIsWanted) {
  PointTable table = Table(1);
  for (const char* name : {"k1", "k2", "a", "b", "c"}) table.Set({name, std::vector<float>(1)});
  const ReportQuantities few = ChooseQuantities(table, All(table), {.most = 3});
  EXPECT_THAT(Names(few), ElementsAre("k1", "k2", "a"));
  EXPECT_THAT(few.left_out, ElementsAre("b", "c"));
  const ReportQuantities wanted = ChooseQuantities(table, All(table), {.most = 3, .wanted = "c"});
  EXPECT_THAT(Names(wanted), ElementsAre("k1", "k2", "c"));
  EXPECT_THAT(wanted.left_out, ElementsAre("a", "b"));
}

TEST(ChooseQuantitiesTest, HasNoCurvatureWhereTheStatusIsNotOk) {
  PointTable table = Table(3);
  table.Set({"mean_curvature", std::vector<float>{1, 0, 2}});
  table.Set({"radius", std::vector<float>{3, 4, 5}});
  table.Set({"status", std::vector<uint8_t>{1, 2, 1}});
  const ReportQuantities quantities = ChooseQuantities(table, All(table), {.most = 12});
  EXPECT_TRUE(std::isnan(quantities.shown[0].values[1]));
  EXPECT_EQ(quantities.shown[0].finite, 2u);
  EXPECT_THAT(quantities.shown[1].values, ElementsAre(3, 4, 5));
}

TEST(ChooseQuantitiesTest, SumsUpAllPointsAndKeepsTheChosen) {
  PointTable table = Table(201);
  std::vector<double> values(201);
  std::iota(values.begin(), values.end(), 0.0);
  values[200] = kNaN;
  table.Set({"a", values});
  const ReportQuantity quantity = ChooseQuantities(table, {5, 200}, {.most = 12}).shown[0];
  EXPECT_EQ(quantity.finite, 200u);
  EXPECT_EQ(quantity.percentiles[0], 0.0);
  EXPECT_EQ(quantity.percentiles[4], 100.0);  // rank 99.5 of 199, rounded
  EXPECT_EQ(quantity.percentiles[8], 199.0);
  EXPECT_EQ(quantity.values.size(), 2u);
  EXPECT_EQ(quantity.values[0], 5.0);
  EXPECT_FALSE(quantity.is_signed);
  EXPECT_EQ(quantity.low, quantity.percentiles[1]);
  EXPECT_EQ(quantity.high, quantity.percentiles[7]);
}

TEST(ChooseQuantitiesTest, MakesSignedColorsSymmetric) {
  PointTable table = Table(4);
  table.Set({"a", std::vector<double>{-1, 3, 0.5, 2}});
  const ReportQuantity quantity = ChooseQuantities(table, All(table), {.most = 12}).shown[0];
  EXPECT_TRUE(quantity.is_signed);
  EXPECT_EQ(quantity.low, -quantity.high);
}

TEST(ChooseQuantitiesTest, KeepsEndsOfColorsApartAndFinite) {
  constexpr double kMost = std::numeric_limits<double>::max();
  const std::vector<std::vector<double>> columns = {
      {5, 5}, {0, 0}, {kNaN, kNaN}, {kMost, kMost}, {-kMost, kMost}, {-kMost, -kMost / 2}, {1e-320, 1e-320}};
  for (const std::vector<double>& column : columns) {
    PointTable table = Table(2);
    table.Set({"a", column});
    const ReportQuantity quantity = ChooseQuantities(table, All(table), {.most = 12}).shown[0];
    EXPECT_LT(quantity.low, quantity.high) << column[0];
    EXPECT_TRUE(std::isfinite(quantity.high - quantity.low)) << column[0];
  }
}

TEST(StatusesOfTest, TakesWholeNumbersOfAByteAlone) {
  PointTable table = Table(2);
  EXPECT_TRUE(StatusesOf(table).empty());
  table.Set({"status", std::vector<float>{1, 7}});
  EXPECT_THAT(StatusesOf(table), ElementsAre(1, 7));
  table.Set({"status", std::vector<float>{1, 1.5}});
  EXPECT_TRUE(StatusesOf(table).empty());
  table.Set({"status", std::vector<int32_t>{1, 256}});
  EXPECT_TRUE(StatusesOf(table).empty());
}

}  // namespace
}  // namespace curv
