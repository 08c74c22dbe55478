#include "core/base/number_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

namespace curvd {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(NumberTextTest, IsAsShortAsTheNumber) {
  EXPECT_EQ(NumberText(0.1), "0.1");
  EXPECT_EQ(NumberText(0.1f), "0.1");
  EXPECT_EQ(NumberText(100'000.0), "100000");
  EXPECT_EQ(NumberText(-2.5e-17), "-2.5e-17");
  EXPECT_EQ(NumberText(0.0), "0");
}

TEST(NumberTextTest, TellsNumbersBesideABoundFromIt) {
  EXPECT_EQ(NumberText(1.0000001), "1.0000001");
  EXPECT_EQ(NumberText(std::nextafter(1.0, 2.0)), "1.0000000000000002");
  EXPECT_EQ(NumberText(std::nextafter(1.0f, 2.0f)), "1.0000001");
  EXPECT_EQ(NumberText(1.0 / 1024), "0.0009765625");
}

TEST(NumberTextTest, NamesWhatIsNotFinite) {
  EXPECT_EQ(NumberText(std::nan("")), "nan");
  EXPECT_EQ(NumberText(-std::nan("")), "nan");
  EXPECT_EQ(NumberText(kInfinity), "inf");
  EXPECT_EQ(NumberText(-kInfinity), "-inf");
}

TEST(NumberTextTest, HoldsTheEndsOfTheRange) {
  for (const double end : {std::numeric_limits<double>::denorm_min(), std::numeric_limits<double>::max()}) {
    EXPECT_EQ(std::strtod(NumberText(end).c_str(), nullptr), end);
  }
}

TEST(VectorTextTest, WritesEachCoordinateInFull) {
  EXPECT_EQ(VectorText(std::array{0.1f, 1e9f, -3.0f}), "(0.1, 1e+09, -3)");
  EXPECT_EQ(VectorText(std::array{0.0, 1.0000001, kInfinity}), "(0, 1.0000001, inf)");
}

}  // namespace
}  // namespace curvd
