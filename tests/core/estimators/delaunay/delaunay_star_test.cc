// How long the walk around a star may be, on each instruction set that this machine has.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/core/estimators/delaunay/delaunay_star_test.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include <cmath>
#include <vector>

#include "core/estimators/delaunay/delaunay_star-inl.h"
#include "hwy/highway.h"

#ifndef CURVD_TESTS_CORE_ESTIMATORS_DELAUNAY_PLANE_POINT_
#define CURVD_TESTS_CORE_ESTIMATORS_DELAUNAY_PLANE_POINT_
namespace curvd {

struct PlanePoint {
  double x, y;
};
struct WalkLength {
  int corners, steps, most_steps;
};

}  // namespace curvd
#endif

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

WalkLength CallWalk(const std::vector<PlanePoint>& points) {
  DelaunayStar star;
  std::vector<int32_t> ids(points.size());
  for (int i = 0; i < DelaunayStar::kCapacity; ++i) star.x[i] = star.y[i] = star.length[i] = 0.0;
  for (size_t i = 0; i < points.size(); ++i) {
    ids[i] = static_cast<int32_t>(i);
    star.x[i] = points[i].x;
    star.y[i] = points[i].y;
    star.length[i] = std::sqrt(points[i].x * points[i].x + points[i].y * points[i].y);
  }
  star.id = ids.data();
  star.own_id = static_cast<int32_t>(points.size());
  star.count = static_cast<int>(points.size());
  int rim[Umbrella::kMaxRim];
  const int corners = star.Walk(rim);
  return {corners, star.steps, DelaunayStar::kMostSteps};
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "core/estimators/triangles/random_stream.h"
#include "tests/core/instruction_sets.h"

namespace curvd {
HWY_EXPORT(CallWalk);

namespace testing {
namespace {

constexpr size_t kPoints = kUmbrellaNeighbors;

class DelaunayStarTest : public InstructionSetTest {
 protected:
  // Points at `radius(i)` and `turn(i)`, in turns around the origin.
  template <typename Radius, typename Turn>
  WalkLength Walk(Radius radius, Turn turn) {
    std::vector<PlanePoint> points;
    for (size_t i = 0; i < kPoints; ++i) {
      const double angle = 2.0 * std::numbers::pi * turn(i);
      points.push_back({radius(i) * std::cos(angle), radius(i) * std::sin(angle)});
    }
    const WalkLength length = HWY_DYNAMIC_DISPATCH(CallWalk)(points);
    EXPECT_LE(length.steps, length.most_steps);
    EXPECT_LE(length.corners, Umbrella::kMaxRim);
    most_ = std::max(most_, length.steps);
    return length;
  }

  int most_ = 0;
};

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, DelaunayStarTest, InstructionSets(), InstructionSetName);

TEST_P(DelaunayStarTest, AWalkEndsAfterAsManyStepsAsTheRimHasRoom) {
  const auto one = [](size_t) { return 1.0; };
  const auto even = [](size_t i) { return static_cast<double>(i) / kPoints; };
  Walk(one, even);                                           // all on a circle
  Walk(one, [&](size_t i) { return 0.4 * even(i); });        // on less than half of one
  Walk(one, [&](size_t i) { return 0.5 * even(i % 2); });    // two places
  Walk(one, [](size_t) { return 0.1; });                     // one place
  Walk([](size_t) { return 0.0; }, even);                    // the origin
  Walk([](size_t i) { return std::exp2(-2.0 * i); }, even);  // a spiral
  for (uint64_t seed = 0; seed < 2000; ++seed) {
    RandomStream random(seed, 0);
    const double spread = 0.02 * static_cast<double>(seed % 50 + 1);
    const auto draw = [&random] { return static_cast<double>(random.Next() >> 11) * 0x1p-53; };
    // Near a circle, where many corners are on the rim; over a part of it, or all of it.
    Walk([&](size_t) { return 1.0 + 1e-3 * draw(); }, [&](size_t) { return spread * draw(); });
  }
  EXPECT_EQ(most_, Umbrella::kMaxRim);
}

TEST_P(DelaunayStarTest, StepsAreThoseOfTheLastWalk) {
  const auto one = [](size_t) { return 1.0; };
  const WalkLength square = Walk(one, [](size_t i) { return static_cast<double>(i % 4) / 4; });
  EXPECT_EQ(square.corners, 5);  // the first one closes the rim
  EXPECT_EQ(square.steps, 4);
}

}  // namespace
}  // namespace testing
}  // namespace curvd

#endif  // HWY_ONCE
