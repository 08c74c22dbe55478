// A counter-based random generator: draw j of point i depends on (seed, i, j) alone, so that results do not depend on
// which thread estimates which point, or when.
#pragma once

#include <cstdint>

namespace curvd {

// The finalizer of splitmix64 (Steele, Lea, Flood: Fast Splittable Pseudorandom Number Generators, 2014).
constexpr uint64_t MixBits(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

class RandomStream {
 public:
  constexpr RandomStream(uint64_t seed, uint64_t point)
      : state_(MixBits(MixBits(seed + kIncrement) + (point + 1) * kIncrement)) {}

  constexpr uint64_t Next() { return MixBits(state_ += kIncrement); }

  // Draw j, counted from 0, is MixBits of this and j + 1 increments, before the first draw.
  constexpr uint64_t state() const { return state_; }
  static constexpr uint64_t kIncrement = 0x9E3779B97F4A7C15u;

 private:
  uint64_t state_;
};

// Maps the low 21 bits of `bits` to [0, bound); a value's odds are off by at most bound / 2^21. REQUIRES: bound < 2^21.
constexpr uint32_t Draw21(uint64_t bits, uint32_t bound) {
  return static_cast<uint32_t>(((bits & 0x1FFFFF) * bound) >> 21);
}

}  // namespace curvd
