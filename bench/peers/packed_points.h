// Packed triples as nanoflann reads them.
#pragma once

#include <cstddef>
#include <nanoflann.hpp>

namespace curvd::bench {

template <typename Scalar>
struct PackedPoints {
  const Scalar* triples;
  size_t count;

  size_t kdtree_get_point_count() const { return count; }
  Scalar kdtree_get_pt(size_t i, size_t axis) const { return triples[3 * i + axis]; }
  template <typename Bounds>
  bool kdtree_get_bbox(Bounds&) const {
    return false;  // nanoflann computes it
  }
};

template <typename Scalar>
using NanoflannTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<Scalar, PackedPoints<Scalar>>,
                                                          PackedPoints<Scalar>, 3>;

}  // namespace curvd::bench
