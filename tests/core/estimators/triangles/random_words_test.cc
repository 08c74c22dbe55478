// Draws by vectors against those one by one, on each instruction set that this machine has.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/core/estimators/triangles/random_words_test.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/triangles/random_words-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Sets the next 48 words of a stream, and what Draw21 makes of each below `bound`.
void DrawWords(const RandomStream& stream, uint32_t bound, uint64_t* words, uint64_t* draws) {
  const WordTag d;
  RandomWords random(stream);
  for (size_t j = 0; j < 48; j += hn::Lanes(d)) {
    const WordVec next = random.Next();
    hn::StoreU(next, d, words + j);
    hn::StoreU(Draw21(next, hn::Set(d, bound)), d, draws + j);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <gtest/gtest.h>

#include "tests/core/instruction_sets.h"

namespace curvd {
HWY_EXPORT(DrawWords);

namespace testing {
namespace {

using RandomWordsTest = InstructionSetTest;

INSTANTIATE_TEST_SUITE_P(EachInstructionSet, RandomWordsTest, InstructionSets(), InstructionSetName);

TEST_P(RandomWordsTest, AreThoseOfTheStreamInTurn) {
  for (const uint32_t bound : {1u, 3u, 50u, 300u, 2'097'151u}) {
    const RandomStream start(7, bound);
    uint64_t words[48], draws[48];
    HWY_DYNAMIC_DISPATCH(DrawWords)(start, bound, words, draws);
    RandomStream one_by_one = start;
    for (int j = 0; j < 48; ++j) {
      const uint64_t expected = one_by_one.Next();
      EXPECT_EQ(words[j], expected) << j;
      EXPECT_EQ(draws[j], Draw21(expected, bound)) << "below " << bound << ", " << j;
    }
  }
}

}  // namespace
}  // namespace testing
}  // namespace curvd

#endif  // HWY_ONCE
