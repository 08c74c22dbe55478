#include "client/report/quantize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace curv {
namespace {

// As IEEE 754 defines binary16.
double HalfValue(uint16_t bits) {
  const int exponent = (bits >> 10) & 31, places = bits & 1023;
  double value = exponent == 0 ? std::ldexp(places, -24) : std::ldexp(1024 + places, exponent - 25);
  if (exponent == 31) value = places == 0 ? std::numeric_limits<double>::infinity() : std::nan("");
  return (bits & 0x8000) != 0 ? -value : value;
}

TEST(HalfBitsTest, GivesEveryHalfItsOwnBits) {
  for (uint32_t bits = 0; bits < 65536; ++bits) {
    const double value = HalfValue(static_cast<uint16_t>(bits));
    if (std::isnan(value)) continue;
    EXPECT_EQ(HalfBits(value), bits);
  }
}

TEST(HalfBitsTest, RoundsToTheNearestAndTiesToEven) {
  EXPECT_EQ(HalfBits(1.0 + 1.0 / 2048), 0x3c00);  // between 1 and the next
  EXPECT_EQ(HalfBits(1.0 + 3.0 / 2048), 0x3c02);
  EXPECT_EQ(HalfBits(std::nextafter(1.0 + 1.0 / 2048, 2.0)), 0x3c01);
  for (double value = 1e-4; value < 6e4; value *= 1.0137) {
    EXPECT_LE(std::abs(HalfValue(HalfBits(value)) - value), kHalfPrecision * value) << value;
    EXPECT_EQ(HalfBits(-value), HalfBits(value) | 0x8000);
  }
}

TEST(HalfBitsTest, KnowsWhatIsNoNumberAndWhatIsTooLarge) {
  EXPECT_EQ(HalfBits(std::nan("")), 0x7e00);
  EXPECT_EQ(HalfBits(kLargestHalf), 0x7bff);
  EXPECT_EQ(HalfBits(65520.0), 0x7c00);
  EXPECT_EQ(HalfBits(-std::numeric_limits<double>::infinity()), 0xfc00);
  EXPECT_EQ(HalfBits(1e-300), 0);
}

double Angle(const Vec3& a, const Vec3& b) { return std::atan2(Norm(Cross(a, b)), Dot(a, b)); }

TEST(OctahedralCodeTest, KeepsDirectionsToItsPrecision) {
  double worst = 0.0;
  constexpr int kCount = 200'000;
  for (int i = 0; i < kCount; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kCount, turn = 2.39996 * i, ring = std::sqrt(1.0 - z * z);
    const Vec3 direction{ring * std::cos(turn), ring * std::sin(turn), z};
    worst = std::max(worst, Angle(direction, OctahedralDirection(OctahedralCode(direction))));
  }
  EXPECT_LE(worst, kDirectionPrecision);
  EXPECT_GT(worst, 0.5 * kDirectionPrecision) << "the promise could be better";
}

TEST(OctahedralCodeTest, DependsOnNoLength) {
  const Vec3 direction{0.3, -0.5, -0.8};
  for (const double length : {1e-300, 1e-3, 1.0, 1e300}) {
    EXPECT_EQ(OctahedralCode(length * direction), OctahedralCode(direction));
  }
}

TEST(OctahedralCodeTest, KnowsWhatIsNoDirection) {
  const std::array<int8_t, 2> none{kNoDirection, kNoDirection};
  EXPECT_EQ(OctahedralCode({0, 0, 0}), none);
  EXPECT_EQ(OctahedralCode({std::nan(""), 0, 1}), none);
  EXPECT_EQ(OctahedralCode({0, std::numeric_limits<double>::infinity(), 1}), none);
}

TEST(FirstTangentTest, LiesAcrossTheNormal) {
  for (const Vec3& normal : {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{1, 0, 0}, Normalized({1, -2, -3})}) {
    const Vec3 tangent = FirstTangent(normal);
    EXPECT_NEAR(Norm(tangent), 1.0, 1e-12);
    EXPECT_NEAR(Dot(tangent, normal), 0.0, 1e-12);
  }
}

TEST(AngleCodeTest, KeepsLinesToHalfAStep) {
  const Vec3 normal = Normalized({1, -2, 0.5}), first = FirstTangent(normal), second = Cross(normal, first);
  for (double angle = -3.5; angle < 3.5; angle += 0.01) {
    const Vec3 direction = std::cos(angle) * first + std::sin(angle) * second;
    const uint8_t code = AngleCode(normal, direction);
    const double decoded = code * std::numbers::pi / kAngleSteps;
    EXPECT_LE(std::abs(std::sin(decoded - angle)), 0.5001 * std::numbers::pi / kAngleSteps) << angle;
    EXPECT_EQ(AngleCode(normal, -direction), code);
  }
}

TEST(AngleCodeTest, KnowsWhatIsNoAngle) {
  EXPECT_EQ(AngleCode({0, 0, 1}, {0, 0, 5}), kNoAngle);
  EXPECT_EQ(AngleCode({0, 0, 1}, {0, 0, 0}), kNoAngle);
  EXPECT_EQ(AngleCode({0, 0, 1}, {std::nan(""), 1, 0}), kNoAngle);
}

}  // namespace
}  // namespace curv
