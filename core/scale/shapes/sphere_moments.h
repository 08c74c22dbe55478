// Sums over the neighbors of a sampled point that algebraic spheres are fitted from, at any radius.
#pragma once

#include <array>
#include <cstddef>

#include "core/scale/pilot/pilot_batch.h"

namespace curvd {

// Sums of products of a left and a right factor, with q the offset of a neighbor, n its normal: weights that are
// polynomials of |q|^2 / radius^2, and their derivatives, are made of these whatever the radius is.
class SphereMoments {
 public:
  // 1, x, y, z, the components of n, q n.
  static constexpr size_t kOne = 0, kOffset = 1, kNormal = 4, kOffsetNormal = 7, kRights = 8;
  // 1, |q|^2, |q|^4; then q, then |q|^2 q; then the products of two components of q: xx xy xz yy yz zz.
  static constexpr size_t kPlain = 0, kSquared = 1, kFourth = 2, kLinear = 3, kCubic = 6, kProducts = 9, kLefts = 15;
  // By which power of a length each left factor grows.
  static constexpr std::array<size_t, kLefts> kLeftDegrees = {0, 2, 4, 1, 1, 1, 3, 3, 3, 2, 2, 2, 2, 2, 2};

  // The sums depend on which neighbors a batch holds, and in what order; they are the same on every machine. What
  // follows the neighbors in the batch is overwritten.
  void Add(PilotBatch& batch);
  SphereMoments& operator+=(const SphereMoments& other);

  double sum(size_t left, size_t right) const { return values_[left * kRights + right]; }
  double sixth() const { return values_[kSixth]; }  // of |q|^6

 private:
  static constexpr size_t kSixth = kLefts * kRights;
  std::array<double, kSixth + 1> values_{};
};

}  // namespace curvd
