// The first half of SampleEvenly: positions in proportion to area, one octree cell after another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/surfaces/surface.h"

namespace curv {

struct ShellSample {
  std::vector<Vec3> positions;  // on the surface, in the order of a space-filling curve
  double area;                  // of the surface, to about a percent
};

// Returns `points` positions on `surface`, their density uniform in area and less clumped than independent draws.
//
// The thin shell |f| <= h |gradient f| is cut into octree cells much smaller than the spacing of the points. One
// jittered trial a cell hits the shell or not, hits are counted along the space-filling curve, and every n-th is kept
// and projected. Shell volume is area times 2 h up to a relative h^2 times the Gaussian curvature. REQUIRES: points
// >= 1.
ShellSample SampleShell(const Surface& surface, size_t points, uint64_t seed);

}  // namespace curv
