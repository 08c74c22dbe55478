// The scale bar beside a picture: what the colors mean.
#pragma once

#include <string>
#include <vector>

#include "client/render/color_scale.h"
#include "client/render/image.h"

namespace curv {

struct Tick {
  double value;
  std::string label;
};

// Round values in [low, high], 3 to 9 of them, with just the digits that tell them apart. REQUIRES: low < high, finite.
std::vector<Tick> RoundTicks(double low, double high);

struct LegendText {
  std::vector<std::string> title;  // a line each
  bool has_missing = false;        // also explain kNoValueColor
};

// Width in pixels that DrawLegend takes at the right side of a picture of that height.
int LegendWidth(int image_height);

// Draws title, bar and ticks into the right side of `image`.
void DrawLegend(const ColorScale& scale, const LegendText& text, Image& image);

}  // namespace curv
