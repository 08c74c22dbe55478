// Draws points as discs that blend into a closed surface.
#pragma once

#include <vector>

#include "client/render/image.h"
#include "client/surfaces/vec3.h"

namespace curv {

// A disc in picture coordinates: x and y in pixels (y downward), z in pixels toward the viewer.
struct Splat {
  Vec3 center;
  Vec3 normal;    // unit, to the right, upward, toward the viewer
  double radius;  // in pixels
  Color color{};
};

// Draws the splats over `image`'s pixels, lit from the upper left. Where discs overlap at about one depth, their colors
// and normals are averaged, weighted toward the discs' centers, so that neither shows an edge between points. The side
// away from the normals is lit in the same way. Anti-aliased by `oversampling` samples a pixel in each direction.
// Returns how near, as z of a splat, the disc is that each pixel shows in its first sample, by rows as the image has
// them; minus infinity where there is none. REQUIRES: all coordinates finite, oversampling >= 1.
std::vector<float> DrawSplats(const std::vector<Splat>& splats, int oversampling, Image& image);

}  // namespace curv
