// Draws of a RandomStream (core/estimators/triangles/random_stream.h), a vector of them at a time.

#if defined(CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_WORDS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_WORDS_INL_H_
#undef CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_WORDS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_WORDS_INL_H_
#endif

#include <cstddef>
#include <cstdint>

#include "core/estimators/triangles/random_stream.h"
#include "core/index/vectors-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Half as many lanes as the numbers of 32 bits that are made of them; as many in scalar code.
using WordTag = hn::CappedTag<uint64_t, SpatialIndex::kLeafSize / 2>;
using WordVec = hn::Vec<WordTag>;

HWY_INLINE WordVec MixBits(WordVec x) {
  const WordTag d;
  x = hn::Mul(hn::Xor(x, hn::ShiftRight<30>(x)), hn::Set(d, 0xBF58476D1CE4E5B9u));
  x = hn::Mul(hn::Xor(x, hn::ShiftRight<27>(x)), hn::Set(d, 0x94D049BB133111EBu));
  return hn::Xor(x, hn::ShiftRight<31>(x));
}

// Draw21 in each lane. REQUIRES: bounds < 2^21.
HWY_INLINE WordVec Draw21(WordVec bits, WordVec bound) {
#if HWY_TARGET == HWY_SCALAR
  return hn::Set(WordTag(), curvd::Draw21(hn::GetLane(bits), static_cast<uint32_t>(hn::GetLane(bound))));
#else
  const WordTag d;
  const hn::Repartition<uint32_t, WordTag> halves;
  const WordVec low = hn::And(bits, hn::Set(d, 0x1FFFFF));
  return hn::ShiftRight<21>(hn::MulEven(hn::BitCast(halves, low), hn::BitCast(halves, bound)));
#endif
}

// The draws of a stream in turn.
class RandomWords {
 public:
  explicit HWY_INLINE RandomWords(const RandomStream& stream) {
    const WordTag d;
    constexpr uint64_t kStep = RandomStream::kIncrement;
    alignas(64) static constexpr uint64_t kSteps[8] = {kStep,     2 * kStep, 3 * kStep, 4 * kStep,
                                                       5 * kStep, 6 * kStep, 7 * kStep, 8 * kStep};
    state_ = hn::Add(hn::Set(d, stream.state()), hn::Load(d, kSteps));
  }
  HWY_INLINE WordVec Next() {
    const WordTag d;
    const WordVec words = MixBits(state_);
    state_ = hn::Add(state_, hn::Set(d, hn::Lanes(d) * RandomStream::kIncrement));
    return words;
  }

 private:
  WordVec state_;
};

// The numbers of two vectors of words below 2^31, one after the other; of the first alone in scalar code.
HWY_INLINE hn::Vec<IntTag> NarrowWords(WordVec first, [[maybe_unused]] WordVec second) {
#if HWY_TARGET == HWY_SCALAR
  return hn::Set(IntTag(), static_cast<int32_t>(hn::GetLane(first)));
#else
  const IntTag d;
  return hn::ConcatEven(d, hn::BitCast(d, second), hn::BitCast(d, first));
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_TRIANGLES_RANDOM_WORDS_INL_H_
