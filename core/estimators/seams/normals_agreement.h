// How far the normals of a cloud agree about the sides of its surface.
#pragma once

#include <cstdint>

namespace curvd {

// Counts over the points that were estimated. Where all normals point to one side, all but `near_pairs` are 0.
struct NormalsAgreement {
  // A near pair is a point and one of its this many nearest neighbors.
  static constexpr int kNearest = 6;

  uint64_t near_pairs = 0;
  uint64_t opposed_pairs = 0;  // near pairs on one sheet whose normals point to its opposite sides
  uint64_t seam_points = 0;    // points beside a seam: a neighbor on their sheet has an opposed normal
  // Parts of a surface to turn for its normals to agree with those of its largest part (FlippedPatches); 0 in what a
  // worker counts.
  uint64_t flipped_patches = 0;

  void Add(const NormalsAgreement& other) {
    near_pairs += other.near_pairs;
    opposed_pairs += other.opposed_pairs;
    seam_points += other.seam_points;
    flipped_patches += other.flipped_patches;
  }
};

}  // namespace curvd
