// Draws a picture of a cloud, colored by a quantity.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/render/camera.h"
#include "client/render/color_scale.h"
#include "client/render/image.h"
#include "client/render/strokes.h"
#include "client/surfaces/vec3.h"

namespace curv {

// What one panel of a picture shows.
struct Layer {
  std::vector<double> values{};       // of each point; grey where NaN
  std::string title{};                // of the scale bar
  std::string unit{};                 // of the values; DEFAULT: none is named
  std::optional<ColorScale> scale{};  // DEFAULT: ColorScale::ForValues
};

struct PictureOptions {
  int width = 1200;  // DEFAULT: 1200 pixels
  int height = 900;  // DEFAULT: 900 pixels
  View view{};
  std::vector<StrokeField> strokes{};  // DEFAULT: none; at most 2
};

inline constexpr int kMinPictureSide = 64;
inline constexpr int kMaxPictureSide = 4096;

// How many panels stand side by side, and one below the other.
struct PanelGrid {
  int columns;
  int rows;
};

// Returns the grid of so many panels that leaves the most room to each in a picture of that size: the largest square
// beside its scale bar; of equal ones that with fewer columns. REQUIRES: panels >= 1.
PanelGrid ArrangePanels(int panels, int width, int height);

// Draws the points as shaded discs with a scale bar beside them, once for each layer, as panels of one size by rows;
// strokes lie over all of them. The cloud may be of any size, one point included; lengths are relative to it. Points
// without a finite position are left out, those with a NaN value are grey; a normal that is no direction is taken to
// face the viewer.
// INVALID_ARGUMENT if no point has a finite position, or a panel would be smaller than kMinPictureSide;
// FAILED_PRECONDITION if no font is installed and the panels are large enough for a scale bar.
// REQUIRES: the arrays are equally long, there is a layer; width and height from kMinPictureSide to kMaxPictureSide.
absl::StatusOr<Image> DrawPicture(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                                  const std::vector<Layer>& layers, const PictureOptions& options);

}  // namespace curv
