// Surfaces with exact curvature that are no surfaces of curv generate. No rule of the core was made by the first three:
// it is tried on them.
#pragma once

#include <memory>
#include <string_view>

#include "client/surfaces/surface.h"

namespace curvd::bench {

// Returns the surface of that name, or null:
// - peanut: the oval of Cassini with distances whose product is 1.21 from (1, 0, 0) and (-1, 0, 0), turned around the x
//   axis; its waist is a saddle
// - lumpy: x^2 + y^2 + z^2 + 0.6 x y z = 1, a sphere with four lumps
// - pillow: x^4 / 16 + y^2 + z^2 = 1, whose curvature along x vanishes in the middle
// - catenoid: x^2 + y^2 = cosh(z)^2, cut off at z = -1.2 and 1.2: its mean curvature is 0 everywhere
// - gyroid: sin x cos y + sin y cos z + sin z cos x = 0, cut off at the faces of a cube of 4.4: nearly the minimal
//   surface of that name
// - hammered: a unit sphere with a dozen waves of length 0.2 all over it, 4 to 8 spacings of 5,000 to 20,000 points
std::unique_ptr<curv::Surface> MakeHeldOutSurface(std::string_view name);

}  // namespace curvd::bench
