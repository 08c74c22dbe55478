// Makes short codes of numbers and directions, for files that shall be small. All functions are thread-safe.
#pragma once

#include <array>
#include <cstdint>

#include "client/surfaces/vec3.h"

namespace curv {

// The largest finite number that HalfBits can hold.
inline constexpr double kLargestHalf = 65504.0;
// How far the number of HalfBits is off at most, relative to the number, where that is at least 2^-14: half a unit in
// the last of 11 places.
inline constexpr double kHalfPrecision = 1.0 / 2048.0;

// Returns the bits of the IEEE 754 binary16 number nearest to `value`, ties to even. Infinite beyond kLargestHalf, and
// one NaN for all of them.
uint16_t HalfBits(double value);

// The code of a direction that is none.
inline constexpr int8_t kNoDirection = -128;
// How far a direction is off at most when it is decoded, in radians: 0.7 degrees.
inline constexpr double kDirectionPrecision = 0.0122;

// Returns the place of a unit vector on the octahedron that is unfolded into a square, from -127 to 127 along each
// side: of the four around it, that whose direction is nearest. kNoDirection twice for a vector whose length is zero or
// not finite, which need not be 1 otherwise.
std::array<int8_t, 2> OctahedralCode(const Vec3& direction);
// Returns the unit vector of such a code. REQUIRES: it is not kNoDirection.
Vec3 OctahedralDirection(const std::array<int8_t, 2>& code);

// The code of an angle that is none.
inline constexpr uint8_t kNoAngle = 255;
inline constexpr int kAngleSteps = 255;  // a half turn

// Returns the first of two unit vectors that span the plane across a unit normal; the second is normal x first. The
// same operations in the page give the same vector.
Vec3 FirstTangent(const Vec3& normal);

// Returns how far a direction is turned in the plane across the unit vector `normal`, counterclockwise from
// FirstTangent, in steps of 1 / kAngleSteps of a half turn; opposite directions are the same. kNoAngle if the direction
// is not finite or has no part in the plane. REQUIRES: normal is a unit vector.
uint8_t AngleCode(const Vec3& normal, const Vec3& direction);

}  // namespace curv
