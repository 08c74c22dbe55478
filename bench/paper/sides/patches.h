// Surfaces as maps of the unit square, for clouds whose sides are known.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "client/surfaces/vec3.h"

namespace curvd::bench {

// A map of the unit square to a surface, with the normal, and the area that it makes of an area there.
struct Patch {
  std::string name;
  bool is_open;
  double most_area;  // of the map, per unit square
  double area;       // of the surface
  std::function<double(double u, double v, curv::Vec3& position, curv::Vec3& normal)> at;
};

// Closed and open surfaces: those by which nothing was chosen (`is_check`), or the others.
std::vector<Patch> Patches(bool is_check);

// Thin bodies that are round, `thickness` spacings thin if they have so many points: lenses and hollow balls, and pots;
// of those by which nothing was chosen, pots alone.
std::vector<Patch> Shells(size_t points, double thickness, bool is_check);

}  // namespace curvd::bench
