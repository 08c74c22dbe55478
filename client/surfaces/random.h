// Random numbers that are a function of (seed, stream, index): the same on every machine, in any order.
#pragma once

#include <cstdint>

namespace curv {

// Not a cryptographic generator. Thread-safe: it has no state.
class CounterRandom {
 public:
  // Streams of the same seed are independent of each other.
  constexpr CounterRandom(uint64_t seed, uint64_t stream) : key_(Mix(Mix(seed) + stream)) {}

  // 64 random bits.
  constexpr uint64_t Bits(uint64_t index) const { return Mix(key_ ^ Mix(index)); }
  // Uniform in [0, 1).
  constexpr double Uniform(uint64_t index) const { return static_cast<double>(Bits(index) >> 11) * 0x1p-53; }
  // Normal with mean 0 and standard deviation 1.
  double Gaussian(uint64_t index) const;

 private:
  // The finalizer of splitmix64 (Steele, Lea, Flood 2014) after one step of its sequence: a bijection of 64 bits.
  static constexpr uint64_t Mix(uint64_t z) {
    z += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }

  uint64_t key_;
};

}  // namespace curv
