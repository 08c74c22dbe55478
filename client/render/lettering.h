// Small text in pictures, drawn with strokes of even width.
#pragma once

#include <string_view>

#include "client/render/image.h"

namespace curv {

// Width in pixels of `text` whose capital letters are `size` pixels high. Characters without a glyph are blank.
double TextWidth(std::string_view text, double size);

// Draws `text` from `x` to the right, its baseline at `y` (pixels, y downward).
void DrawText(std::string_view text, double x, double y, double size, const Color& color, Image& image);

// Draws a line of `width` pixels with round ends, anti-aliased.
void DrawLine(double x0, double y0, double x1, double y1, double width, const Color& color, Image& image);

}  // namespace curv
