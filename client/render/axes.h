// Shows where the axes point in a picture.
#pragma once

#include <cairo.h>

#include "client/render/camera.h"

namespace curv {

// Draws the three axes from the point (x, y), with their names in letters of `size` pixels. Axes that point away from
// the viewer are faint; one that is seen from its end is a ring, with a dot if it points toward the viewer, with a
// cross if not. Takes up to 2.8 sizes in each direction. REQUIRES: CheckFonts() is OK.
void DrawAxes(const View& view, double x, double y, double size, cairo_t* cairo);

}  // namespace curv
