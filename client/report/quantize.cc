#include "client/report/quantize.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace curv {
namespace {

constexpr double kSquareSteps = 127.0;

double SignOf(double value) { return value < 0.0 ? -1.0 : 1.0; }

// A vector of about unit length along `v`, without overflow; zero if it has no direction.
Vec3 Bounded(const Vec3& v) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(largest > 0.0) || !std::isfinite(v.x + v.y + v.z)) return {};
  return {v.x / largest, v.y / largest, v.z / largest};
}

}  // namespace

uint16_t HalfBits(double value) {
  if (std::isnan(value)) return 0x7e00;
  const int sign = std::signbit(value) ? 0x8000 : 0;
  const double size = std::abs(value);
  if (size >= kLargestHalf + 16.0) return static_cast<uint16_t>(sign | 0x7c00);
  if (size == 0.0) return static_cast<uint16_t>(sign);
  int exponent = 0;
  std::frexp(size, &exponent);
  const int unit = std::max(exponent - 11, -24);  // of the last place, as a power of two
  // From 1024 to 2048 in units, unless subnormal; 2048 carries into the exponent by itself.
  const int places = static_cast<int>(std::lrint(std::ldexp(size, -unit)));
  return static_cast<uint16_t>(sign | (((unit + 24) << 10) + places));
}

std::array<int8_t, 2> OctahedralCode(const Vec3& direction) {
  const Vec3 d = Bounded(direction);
  const double sum = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
  if (sum == 0.0) return {kNoDirection, kNoDirection};
  double u = d.x / sum, v = d.y / sum;
  if (d.z < 0.0) {
    const double folded = (1.0 - std::abs(v)) * SignOf(u);
    v = (1.0 - std::abs(u)) * SignOf(v);
    u = folded;
  }
  std::array<int8_t, 2> best{};
  double best_agreement = -2.0;
  for (const double along : {std::floor(u * kSquareSteps), std::ceil(u * kSquareSteps)}) {
    for (const double across : {std::floor(v * kSquareSteps), std::ceil(v * kSquareSteps)}) {
      const std::array<int8_t, 2> code{static_cast<int8_t>(along), static_cast<int8_t>(across)};
      const double agreement = Dot(d, OctahedralDirection(code)) / Norm(d);
      if (agreement <= best_agreement) continue;
      best_agreement = agreement;
      best = code;
    }
  }
  return best;
}

Vec3 OctahedralDirection(const std::array<int8_t, 2>& code) {
  const double u = code[0] / kSquareSteps, v = code[1] / kSquareSteps;
  const double z = 1.0 - std::abs(u) - std::abs(v);
  if (z >= 0.0) return Normalized({u, v, z});
  return Normalized({(1.0 - std::abs(v)) * SignOf(u), (1.0 - std::abs(u)) * SignOf(v), z});
}

Vec3 FirstTangent(const Vec3& normal) {
  const double sign = SignOf(normal.z);
  const double a = -1.0 / (sign + normal.z);
  return {1.0 + sign * normal.x * normal.x * a, sign * normal.x * normal.y * a, -sign * normal.x};
}

uint8_t AngleCode(const Vec3& normal, const Vec3& direction) {
  const Vec3 d = Bounded(direction);
  const Vec3 first = FirstTangent(normal);
  const double along = Dot(d, first), across = Dot(d, Cross(normal, first));
  if (along == 0.0 && across == 0.0) return kNoAngle;
  const double half_turns = std::atan2(across, along) / std::numbers::pi + 1.0;  // from 0 to 2
  return static_cast<uint8_t>(std::lround(half_turns * kAngleSteps) % kAngleSteps);
}

}  // namespace curv
