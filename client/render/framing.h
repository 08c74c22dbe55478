// Chooses how large the discs of a picture are, and where they stand in it.
#pragma once

#include <vector>

#include "client/surfaces/vec3.h"

namespace curv {

// A point as a disc, in coordinates of the view.
struct Disc {
  Vec3 center;
  Vec3 normal;  // unit
  double radius;
};

// Returns radii with which discs at these positions close the surface between them: the distance to the sixth neighbor,
// and for a point with six others at its place the median of the other points'. Lonely points get no more than four
// times the median, and none more than a sixth of the cloud's largest extent. All are above zero; 1 if all positions
// are the same. REQUIRES: there is a position; coordinates are finite and at most 2.
std::vector<double> DiscRadii(const std::vector<Vec3>& positions);

// Takes coordinates of the view to pixels: the center comes to the middle of the picture, everything else to `scale`
// times its distance from there.
struct Framing {
  double scale;  // pixels per length unit, > 0
  Vec3 center;
};

// Fits the discs into width times height pixels with a margin of `margin` pixels all around. However few they are, a
// disc of median size is no wider than a quarter of the room.
// REQUIRES: there is a disc, radii > 0; the margin leaves some room.
Framing FitFrame(const std::vector<Disc>& discs, double width, double height, double margin);

}  // namespace curv
