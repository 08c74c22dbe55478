// Unit normals by vectors against one point at a time, on each instruction set that this machine has.
#include "core/cloud/unit_normals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/core/instruction_sets.h"

namespace curvd::testing {
namespace {

constexpr double kTolerance = 0.01;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

class UnitNormalsTest : public InstructionSetTest {};
INSTANTIATE_TEST_SUITE_P(EachInstructionSet, UnitNormalsTest, InstructionSets(), InstructionSetName);

// Bytes of points, at an address that is aligned for nothing.
class Packed {
 public:
  explicit Packed(const std::vector<float>& values) : bytes_(1 + values.size() * sizeof(float), '\0') {
    std::memcpy(bytes_.data() + 1, values.data(), values.size() * sizeof(float));
  }
  const char* data() const { return bytes_.data() + 1; }

 private:
  std::string bytes_;
};

double LengthOf(const float* v) {
  const double x = v[0], y = v[1], z = v[2];
  return std::sqrt(x * x + y * y + z * z);
}

void ExpectAsOneByOne(const std::vector<float>& positions, const std::vector<float>& normals) {
  const size_t count = normals.size() / 3;
  UnitNormals unit;
  MakeUnitNormals(Packed(positions).data(), Packed(normals).data(), count, kTolerance, unit);
  for (size_t i = 0; i < UnitNormals::kMaxPoints; ++i) {
    const bool usable = (unit.usable >> i & 1) != 0, rescaled = (unit.rescaled >> i & 1) != 0;
    if (i >= count) {
      EXPECT_FALSE(usable || rescaled) << i;
      continue;
    }
    const float* position = &positions[3 * i];
    const float* normal = &normals[3 * i];
    bool finite = true;
    for (int axis = 0; axis < 3; ++axis) finite &= std::isfinite(position[axis]) && std::isfinite(normal[axis]);
    const double length = LengthOf(normal);
    ASSERT_EQ(usable, finite && length > 0.0) << i;
    if (!usable) continue;
    EXPECT_EQ(rescaled, std::abs(length - 1.0) > kTolerance) << i;
    const double per_length = 1.0 / length;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(unit.normals[i][axis], static_cast<float>(normal[axis] * per_length)) << i << " axis " << axis;
    }
  }
}

TEST_P(UnitNormalsTest, AnyNumberOfPointsIsAsOneByOne) {
  std::mt19937 random(7);
  std::normal_distribution<float> coordinate;
  for (size_t count = 1; count <= UnitNormals::kMaxPoints; ++count) {
    std::vector<float> positions(3 * count), normals(3 * count);
    for (float& value : positions) value = coordinate(random);
    for (float& value : normals) value = coordinate(random);
    ExpectAsOneByOne(positions, normals);
  }
}

TEST_P(UnitNormalsTest, LengthsAtTheEndsOfTheFloatsAndAroundOne) {
  constexpr float kLeast = std::numeric_limits<float>::denorm_min(), kMost = std::numeric_limits<float>::max();
  std::vector<float> normals;
  for (const float length : {kLeast, 1e-40f, 1e-30f, 0.5f, 0.98f, 0.995f, 1.0f, 1.005f, 1.02f, 1e30f, kMost}) {
    normals.insert(normals.end(), {length, 0.0f, 0.0f, 0.0f, -length, length, length, length, length});
  }
  ExpectAsOneByOne(std::vector<float>(normals.size(), 1.0f), normals);
}

TEST_P(UnitNormalsTest, WhatIsNotFiniteOrZeroIsNotUsable) {
  for (size_t count : {3u, 17u, 64u}) {
    for (size_t at = 0; at < 3 * count; ++at) {
      for (const float value : {kInfinity, -kInfinity, kNaN}) {
        std::vector<float> positions(3 * count, 2.0f), normals(3 * count, 0.5f);
        positions[at] = value;
        ExpectAsOneByOne(positions, normals);
        std::swap(positions[at], normals[at]);
        ExpectAsOneByOne(positions, normals);
      }
    }
    std::vector<float> normals(3 * count, 0.5f);
    std::fill_n(normals.end() - 3, 3, -0.0f);
    ExpectAsOneByOne(std::vector<float>(3 * count, 2.0f), normals);
  }
}

}  // namespace
}  // namespace curvd::testing
