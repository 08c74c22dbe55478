// How far the normals of a cloud agree about the sides of its surface.
#pragma once

#include <cstdint>

namespace curvd {

// All are 0 where no seam shows (SeamMarks::ShowSeam); pairs are not counted then.
struct NormalsAgreement {
  // A near pair is a point that gets a result and one of its this many nearest neighbors.
  static constexpr int kNearest = 6;
  // Smaller regions of a surface are no patches but single points and the chance of noise.
  static constexpr int kLeastPatch = 10;

  uint64_t seam_points = 0;  // points without doubt beside a seam: neighbors on their sheet have opposed normals
  uint64_t near_pairs = 0;
  uint64_t opposed_pairs = 0;    // near pairs on one sheet whose normals point to its opposite sides
  uint64_t flipped_patches = 0;  // connected parts of at least kLeastPatch points to turn (AgreementRun)
};

}  // namespace curvd
