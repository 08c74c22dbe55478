// Draws what a picture's colors and directions mean, beside the picture.
#pragma once

#include <string>
#include <vector>

#include "client/render/camera.h"
#include "client/render/color_scale.h"
#include "client/render/image.h"

namespace curv {

struct LegendText {
  std::string title{};       // what the colors show
  std::string unit{};        // of the values, in one line, the rest of which is left out; DEFAULT: none is named
  bool has_missing = false;  // some points have no value: explains kNoValueColor
  bool has_below = false;    // some values are below the scale: its lower end is pointed
  bool has_above = false;    // some values are above the scale: its upper end is pointed
  std::vector<std::string> strokes{};  // what each kind of stroke shows, in the order of DrawStrokes; DEFAULT: none
};

// Size in pixels of the letters of a picture of that size.
double LetterSize(int image_width, int image_height);

// Width in pixels that DrawLegend takes at the right side of a picture of that size; 0 if there is no room for one.
int LegendWidth(int image_width, int image_height);

// Draws title, unit, color bar and ticks into the right side of `image`, and below them where the axes point, if there
// is room. REQUIRES: CheckFonts() is OK, or LegendWidth is 0.
void DrawLegend(const ColorScale& scale, const LegendText& text, const View& view, Image& image);

}  // namespace curv
