// Numbers of each neighbor, column by column, for sums over neighbors in doubles.
#pragma once

#include <cstddef>

#include "core/base/scratch_array.h"

namespace curvd {

// Columns of one number a neighbor. Each begins at a whole vector; what follows its last number up to the end of that
// is for the kernels to set. They lie an odd number of vectors apart: were that a power of two, all of them would meet
// in a few sets of a cache. Not thread-safe.
class FitColumns {
 public:
  // Makes room for `count` columns of `size` numbers, and forgets what they held.
  void Reserve(size_t count, size_t size) {
    stride_ = Stride(size);
    numbers_.Reserve(count * stride_);
  }
  double* column(size_t c) { return numbers_.data() + c * stride_; }

  // Bytes held, and held at most for so many columns and numbers.
  size_t bytes() const { return numbers_.bytes(); }
  static constexpr size_t MostBytes(size_t count, size_t size) {
    return ScratchArray<double>::MostBytes(count * Stride(size));
  }

 private:
  static constexpr size_t Stride(size_t size) {
    constexpr size_t kLongestVector = 8;
    return ((size + kLongestVector - 1) / kLongestVector | 1) * kLongestVector;
  }

  size_t stride_ = 0;
  ScratchArray<double> numbers_;
};

}  // namespace curvd
