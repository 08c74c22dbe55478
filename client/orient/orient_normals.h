// Makes the normals of a cloud point to one side of its surface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/surfaces/vec3.h"

namespace curv {

struct Orientation {
  std::vector<uint8_t> flip;  // 1 where the normal has to be negated
  size_t flipped = 0;         // how many normals have to be negated
  size_t pieces = 0;          // how many parts of the cloud were oriented each for itself
};

// Chooses signs so that normals of neighbors agree, along the tree of most reliable neighborhoods (the minimum spanning
// tree of Hoppe et al. 1992, with the reflection of Koenig and Gumhold 2009 across edges). A piece that is closed gets
// normals that point outward; an open one keeps the side that most of its area had, or most of its points if all lie at
// one place; where both sides have as much, one of them. Coordinates may be as large as numbers go. Points whose
// position or normal is not finite, or whose normal is zero, are left alone. Searches for neighbors on `threads`
// threads, or on one for each core if `threads` is 0; the result does not depend on their number. REQUIRES: as many
// normals as positions, fewer than 2^31; normals need not be of unit length; threads >= 0.
Orientation OrientNormals(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals, int threads = 0);

}  // namespace curv
