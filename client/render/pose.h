// Chooses how a cloud stands in its picture, and from where it is seen, when nobody says so.
#pragma once

#include <optional>
#include <vector>

#include "client/surfaces/vec3.h"

namespace curv {

// How a cloud is shown; angles as MakeView takes them, in degrees.
struct Pose {
  char up_axis = 'z';
  double azimuth = 35.0;
  double elevation = 25.0;
  const char* reason = "";  // why that axis points up, in a few words
};

// Chooses the axis that points up, unless it is given, and then the side from which most is seen. `normals` are those
// of the positions, or none at all. Nothing depends on the length unit, nor on the order of the points but by rounding.
//
// Up is z, or y; files have no other. The first of these that says which decides:
//  1. Where normals, on average, point along +z or +y: what a scan has not seen is what the object stood on. So do
//     terrains. The mean of unit normals is at least 0.1 long, and within 26 degrees of the axis.
//  2. Without normals, a cloud that is three times longer along both other axes lies flat.
//  3. A cloud that is its own mirror image along one of z and y, and not along the other, has left and right there: the
//     other axis is up. As its own mirror image counts one that has half of the cells, of a sixteenth of its size, on
//     both sides.
//  4. Where neither is so, it stands: along y if it is a tenth taller that way, otherwise along z.
// The viewer stands at an azimuth of 35 degrees, unless one of the seven others that are multiples of 45 degrees away
// shows a tenth more of the points from outside; 25 degrees up, or 45 over what is open to above (a mean of 0.5).
// Points and normals that are not finite do not count.
Pose ChoosePose(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                std::optional<char> up_axis = std::nullopt);

}  // namespace curv
