#include "client/cli/files/coarse_positions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace curv {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A sphere of radius 1 around (east, north, 0). 10,000 points on it are about 0.02 apart.
PackedCloud<float> SphereAt(double east, double north, size_t count = 10'000) {
  PackedCloud<float> cloud;
  for (size_t i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
    const double angle = 2.39996 * static_cast<double>(i), ring = std::sqrt(1.0 - z * z);
    for (const double v : {east + ring * std::cos(angle), north + ring * std::sin(angle), z}) {
      cloud.positions.push_back(static_cast<float>(v));
    }
  }
  return cloud;
}

TEST(CoarsePositionsTest, GeoreferencedFloatsAreCoarse) {
  EXPECT_THAT(NoteOnCoarsePositions(SphereAt(5e5, 5e6)),
              AllOf(HasSubstr("near 5e+06, which lie 0.5 apart there"), HasSubstr("Write doubles")));
}

TEST(CoarsePositionsTest, ScansWithoutReturnsAreNoLessCoarse) {
  PackedCloud<float> cloud = SphereAt(5e5, 5e6);
  for (size_t i = 0; i < cloud.positions.size(); i += 90) {  // a point in 30
    const float value = i % 180 == 0 ? 0.0f : std::numeric_limits<float>::quiet_NaN();
    for (size_t axis = 0; axis < 3; ++axis) cloud.positions[i + axis] = value;
  }
  EXPECT_THAT(NoteOnCoarsePositions(cloud), HasSubstr("near 5e+06"));
}

TEST(CoarsePositionsTest, NothingIsSaidOfOthers) {
  EXPECT_THAT(NoteOnCoarsePositions(SphereAt(0.0, 0.0)), IsEmpty());
  EXPECT_THAT(NoteOnCoarsePositions(SphereAt(1e3, 1e3)), IsEmpty()) << "floats lie 6e-5 apart";
  EXPECT_THAT(NoteOnCoarsePositions(SphereAt(5e5, 5e6, 50)), IsEmpty()) << "few points";
  EXPECT_THAT(NoteOnCoarsePositions(PackedCloud<double>{std::vector<double>(3'000, 5e6), {}, {}, {}}), IsEmpty());
  EXPECT_THAT(NoteOnCoarsePositions(PackedCloud<float>{std::vector<float>(3'000, 5e6f), {}, {}, {}}), IsEmpty());
  EXPECT_THAT(NoteOnCoarsePositions(PackedCloud<float>()), IsEmpty());
  // A line and a plane along an axis.
  PackedCloud<float> line, plane;
  for (int i = 0; i < 2'500; ++i) {
    for (const int v : {i, 0, 0}) line.positions.push_back(static_cast<float>(v));
    for (const int v : {i % 50, i / 50, 7}) plane.positions.push_back(static_cast<float>(v));
  }
  EXPECT_THAT(NoteOnCoarsePositions(line), IsEmpty());
  EXPECT_THAT(NoteOnCoarsePositions(plane), IsEmpty());
}

}  // namespace
}  // namespace curv
