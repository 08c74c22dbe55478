// The second half of SampleEvenly: neighbors push each other apart.
#pragma once

#include <vector>

#include "client/surfaces/surface.h"

namespace curv {

// Moves `positions`, which lie on `surface`, until their distances are nearly equal; they stay on the surface and,
// where it is open, within its bounds. `area` is that of the surface. The order of positions changes.
void Relax(const Surface& surface, double area, std::vector<Vec3>& positions);

}  // namespace curv
