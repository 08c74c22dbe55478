// The sums over vectors are those over single neighbors, on each instruction set that this machine has.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/core/estimators/lines/vector_offset_sums_test.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/lines/offset_sums-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Sums `count` pairs of addends, each pair the next two of the array; lanes beyond the last are left out.
void CallSumPairs(const double* pairs, size_t count, double* totals) {
  const DoubleTag d;
  VectorOffsetSums<2> sums;
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    HWY_ALIGN double first[HWY_MAX_BYTES / sizeof(double)] = {}, second[HWY_MAX_BYTES / sizeof(double)] = {};
    for (size_t lane = 0; lane < hn::Lanes(d) && i + lane < count; ++lane) {
      first[lane] = pairs[2 * (i + lane)];
      second[lane] = pairs[2 * (i + lane) + 1];
    }
    sums.Add({hn::Load(d, first), hn::Load(d, second)});
  }
  const std::array<double, 2> total = sums.Total();
  totals[0] = total[0];
  totals[1] = total[1];
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/core/instruction_sets.h"

namespace curvd {
HWY_EXPORT(CallSumPairs);

namespace testing {
namespace {

using VectorOffsetSumsTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, VectorOffsetSumsTest, InstructionSets(), InstructionSetName);

// Addends of every size, and halves of a quantum, which go to even ones.
std::vector<double> RandomPairs(size_t count) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<double> pairs;
  for (size_t i = 0; i < 2 * count; ++i) {
    pairs.push_back(i % 5 == 0 ? (static_cast<double>(random() % 1000) - 499.5) * 0x1p-35
                               : std::ldexp(unit(random), -static_cast<int>(random() % 40)));
  }
  return pairs;
}

TEST_P(VectorOffsetSumsTest, AreThoseOverSingleAddendsInAnyOrder) {
  for (const size_t count : {0, 1, 7, 8, 9, 300, 2048}) {
    std::vector<double> pairs = RandomPairs(count);
    OffsetSums<2> single;
    for (size_t i = 0; i < count; ++i) {
      single.Add(0, pairs[2 * i]);
      single.Add(1, pairs[2 * i + 1]);
    }
    double totals[2];
    HWY_DYNAMIC_DISPATCH(CallSumPairs)(pairs.data(), count, totals);
    EXPECT_EQ(totals[0], single[0]) << count;
    EXPECT_EQ(totals[1], single[1]) << count;
    // Pairs from the last to the first have their own two the other way round.
    std::reverse(pairs.begin(), pairs.end());
    HWY_DYNAMIC_DISPATCH(CallSumPairs)(pairs.data(), count, totals);
    EXPECT_EQ(totals[1], single[0]) << count;
    EXPECT_EQ(totals[0], single[1]) << count;
  }
}

}  // namespace
}  // namespace testing
}  // namespace curvd

#endif  // HWY_ONCE
