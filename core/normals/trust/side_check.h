// Tells whether normals point to the same sides when they are made of other neighborhoods.
//
// Where positions are noisy, the winding number of right normals varies over the points, so that the certificate of a
// cloud that is partly wrong may be no worse. What is wrong there comes from noise, and other neighborhoods make other
// errors of it: sides that stay are right.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/index/spatial_index.h"

namespace curvd {

// Takes less than a millisecond. Not thread-safe.
class SideCheck {
 public:
  // So many points are looked at, at most, at even distances in the tree order.
  static constexpr size_t kMostSamples = 32'768;

  // Keeps the normals that the index has now. May throw std::bad_alloc. REQUIRES: index.has_normals(), NaN where a
  // point has none; it outlives this.
  explicit SideCheck(const SpatialIndex& index);

  // The share of the kept points with a normal then and now whose normals point to another side now; or to the same
  // side if those are fewer, since a piece may turn as a whole.
  double TurnedShare() const;

  size_t bytes() const { return kept_.capacity() * sizeof(kept_[0]); }
  static constexpr size_t kMostBytes = kMostSamples * sizeof(std::array<float, 3>);

 private:
  std::array<float, 3> NormalAt(size_t sample) const;

  const SpatialIndex& index_;
  std::vector<std::array<float, 3>> kept_;
};

}  // namespace curvd
