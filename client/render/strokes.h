// Draws directions on a surface as strokes.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "client/render/image.h"
#include "client/render/splats.h"
#include "client/surfaces/vec3.h"

// Cairo's own name for what cairo_t is, so that who draws pictures need not know cairo.
typedef struct _cairo cairo_t;

namespace curv {

// A direction for each point, of any length; one that is zero or not finite is none.
struct StrokeField {
  std::string name;  // what the legend calls it
  std::vector<Vec3> directions;
};

// Draws strokes along the fields' directions over a picture of the splats: about one every two letters of `size`
// pixels, through the nearest splat to the middle of each such square, among those that are seen, not from their edge,
// and have directions. A stroke that points toward the viewer is shorter. The sign of a direction shows in nothing.
// `depths` are those that DrawSplats returned. REQUIRES: directions are in the coordinates of the view, one for each
// splat.
void DrawStrokes(const std::vector<Splat>& splats, const std::vector<StrokeField>& fields,
                 const std::vector<float>& depths, double size, Image& image);

// Strokes the path of cairo as DrawStrokes does for its field number `kind`, so that a legend can explain it.
void PaintStroke(size_t kind, double size, cairo_t* cairo);

}  // namespace curv
