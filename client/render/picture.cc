#include "client/render/picture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "absl/status/status.h"
#include "client/neighbors/scaled_positions.h"
#include "client/render/framing.h"
#include "client/render/legend.h"
#include "client/render/lettering.h"
#include "client/render/splats.h"

namespace curv {
namespace {

constexpr Color kPaper{1.0f, 1.0f, 1.0f};
constexpr int kOversampling = 2;
constexpr double kMarginShare = 0.05;  // of the shorter side of the place for the cloud

bool IsFinite(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// The direction of `normal` in the view, or toward the viewer if it has none.
Vec3 TurnNormal(const View& view, const Vec3& normal) {
  const double length = Norm(normal);
  return std::isfinite(length) && length > 0.0 ? view.Turn((1.0 / length) * normal) : Vec3{0, 0, 1};
}

// Returns the points of those indices as discs in coordinates of the view, in a length unit of their own.
std::vector<Disc> MakeDiscs(const std::vector<size_t>& shown, const std::vector<Vec3>& positions,
                            const std::vector<Vec3>& normals, const View& view) {
  std::vector<Vec3> turned;
  turned.reserve(shown.size());
  for (const size_t i : shown) turned.push_back(positions[i]);
  ScaleToUnit(turned);
  for (Vec3& position : turned) position = view.Turn(position);
  const std::vector<double> radii = DiscRadii(turned);
  std::vector<Disc> discs(shown.size());
  for (size_t s = 0; s < shown.size(); ++s) {
    discs[s] = {.center = turned[s], .normal = TurnNormal(view, normals[shown[s]]), .radius = radii[s]};
  }
  return discs;
}

// Returns the picture without its legend.
Image DrawCloud(const std::vector<Disc>& discs, const std::vector<Color>& colors, int width, int height) {
  const Framing framing = FitFrame(discs, width, height, kMarginShare * std::min(width, height));
  std::vector<Splat> splats(discs.size());
  for (size_t s = 0; s < discs.size(); ++s) {
    const Vec3 place = framing.scale * (discs[s].center - framing.center);
    splats[s] = {.center = {0.5 * width + place.x, 0.5 * height - place.y, place.z},
                 .normal = discs[s].normal,
                 .radius = framing.scale * discs[s].radius,
                 .color = colors[s]};
  }
  Image image(width, height, kPaper);
  DrawSplats(splats, kOversampling, image);
  return image;
}

// Copies `part` into the upper left corner of `image`, which is no smaller.
void Paste(const Image& part, Image& image) {
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) image.at(x, y) = part.at(x, y);
  }
}

}  // namespace

absl::StatusOr<Image> DrawPicture(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                                  const std::vector<double>& values, const PictureOptions& options) {
  std::vector<size_t> shown;
  for (size_t i = 0; i < positions.size(); ++i) {
    if (IsFinite(positions[i])) shown.push_back(i);
  }
  if (shown.empty()) return absl::InvalidArgumentError("there is no point with a finite position to draw");
  const int legend_width = LegendWidth(options.width, options.height);
  if (absl::Status status = legend_width > 0 ? CheckFonts() : absl::OkStatus(); !status.ok()) return status;

  const ColorScale scale = options.scale ? *options.scale : ColorScale::ForValues(values);
  LegendText legend{.title = options.title, .unit = options.unit};
  std::vector<Color> colors;
  for (const size_t i : shown) {
    legend.has_missing |= std::isnan(values[i]);
    legend.has_below |= values[i] < scale.low();
    legend.has_above |= values[i] > scale.high();
    colors.push_back(scale.ColorOf(values[i]));
  }
  Image image(options.width, options.height, kPaper);
  // A picture of its own, so that no disc reaches into the legend.
  Paste(DrawCloud(MakeDiscs(shown, positions, normals, options.view), colors, options.width - legend_width,
                  options.height),
        image);
  DrawLegend(scale, legend, options.view, image);
  return image;
}

}  // namespace curv
