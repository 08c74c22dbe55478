// Draws a picture of a cloud, colored by a quantity.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/render/camera.h"
#include "client/render/color_scale.h"
#include "client/render/image.h"
#include "client/surfaces/vec3.h"

namespace curv {

struct PictureOptions {
  int width = 1200;  // DEFAULT: 1200 pixels
  int height = 900;  // DEFAULT: 900 pixels
  View view{};
  std::string title{};                // of the scale bar
  std::string unit{};                 // of the values; DEFAULT: none is named
  std::optional<ColorScale> scale{};  // DEFAULT: ColorScale::ForValues
};

inline constexpr int kMinPictureSide = 64;
inline constexpr int kMaxPictureSide = 4096;

// Draws the points as shaded discs with a scale bar beside them. The cloud may be of any size, one point included;
// lengths are relative to it. Points without a finite position are left out, those with a NaN
// value are grey; a normal that is no direction is taken to face the viewer.
// INVALID_ARGUMENT if no point has a finite position; FAILED_PRECONDITION if no font is installed and the picture is
// large enough for a scale bar.
// REQUIRES: the arrays are equally long; width and height from kMinPictureSide to kMaxPictureSide.
absl::StatusOr<Image> DrawPicture(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                                  const std::vector<double>& values, const PictureOptions& options);

}  // namespace curv
