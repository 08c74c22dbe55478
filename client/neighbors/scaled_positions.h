// Brings positions of any size into the range where products of coordinates neither overflow nor vanish.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "client/surfaces/vec3.h"

namespace curv {

// Multiplies all positions by one power of two, so that the largest coordinate is at least 1 and below 2. No bit of a
// coordinate is lost, unless it is 2^970 times smaller than the largest one. Positions that are all zero stay so.
// REQUIRES: positions are finite.
inline void ScaleToUnit(std::vector<Vec3>& positions) {
  double largest = 0.0;
  for (const Vec3& p : positions) largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  if (largest == 0.0) return;
  // In two steps: the factor of a subnormal number would itself overflow.
  const int exponent = -std::ilogb(largest);
  const double first = std::ldexp(1.0, exponent / 2), second = std::ldexp(1.0, exponent - exponent / 2);
  for (Vec3& p : positions) p = second * (first * p);
}

}  // namespace curv
