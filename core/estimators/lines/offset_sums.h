// Sums over neighbors in doubles that are the same in whatever order the neighbors come: addends are rounded to whole
// quanta. For the few points that are looked at twice.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace curvd {

// In what the sums count.
struct OffsetQuanta {
  static constexpr double kPerUnit = 0x1p35;
  static constexpr double kWholeNumbers = 0x1.8p52;  // doubles near it are whole numbers
};

// `kCount` sums of addends of at most 1 or so, of up to 2^27 neighbors.
template <size_t kCount>
class OffsetSums {
 public:
  void Add(size_t sum, double addend) {
    // Leaves the nearest whole number in the low bits: no call, where llrint is one.
    constexpr double kWhole = OffsetQuanta::kWholeNumbers;
    quanta_[sum] += std::bit_cast<int64_t>(addend * OffsetQuanta::kPerUnit + kWhole) - std::bit_cast<int64_t>(kWhole);
  }
  double operator[](size_t sum) const { return static_cast<double>(quanta_[sum]) / OffsetQuanta::kPerUnit; }

 private:
  std::array<int64_t, kCount> quanta_{};
};

}  // namespace curvd
