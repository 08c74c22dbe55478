#include "client/render/picture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
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

// The discs in pixels of a panel without its legend, each of its color to be set.
std::vector<Splat> PlaceDiscs(const std::vector<Disc>& discs, int width, int height) {
  const Framing framing = FitFrame(discs, width, height, kMarginShare * std::min(width, height));
  std::vector<Splat> splats(discs.size());
  for (size_t s = 0; s < discs.size(); ++s) {
    const Vec3 place = framing.scale * (discs[s].center - framing.center);
    splats[s] = {.center = {0.5 * width + place.x, 0.5 * height - place.y, place.z},
                 .normal = discs[s].normal,
                 .radius = framing.scale * discs[s].radius};
  }
  return splats;
}

// Copies `part` into `image`, which has room for it there.
void Paste(const Image& part, int left, int top, Image& image) {
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) image.at(left + x, top + y) = part.at(x, y);
  }
}

// Draws panels of one size, which differ in their colors alone.
class PanelPainter {
 public:
  // `shown` are the points to draw, `splats` their discs, `strokes` directions of them in the view.
  PanelPainter(const PictureOptions& options, int width, int height, std::vector<size_t> shown,
               std::vector<Splat> splats, std::vector<StrokeField> strokes)
      : options_(options),
        width_(width),
        height_(height),
        shown_(std::move(shown)),
        splats_(std::move(splats)),
        strokes_(std::move(strokes)) {}

  Image Draw(const Layer& layer) {
    const ColorScale scale = layer.scale ? *layer.scale : ColorScale::ForValues(layer.values);
    LegendText legend{.title = layer.title, .unit = layer.unit};
    for (const StrokeField& field : strokes_) legend.strokes.push_back(field.name);
    for (size_t s = 0; s < shown_.size(); ++s) {
      const double value = layer.values[shown_[s]];
      legend.has_missing |= std::isnan(value);
      legend.has_below |= value < scale.low();
      legend.has_above |= value > scale.high();
      splats_[s].color = scale.ColorOf(value);
    }
    // A picture of its own, so that no disc reaches into the legend.
    Image cloud(width_ - LegendWidth(width_, height_), height_, kPaper);
    const std::vector<float> depths = DrawSplats(splats_, kOversampling, cloud);
    DrawStrokes(splats_, strokes_, depths, LetterSize(width_, height_), cloud);
    Image panel(width_, height_, kPaper);
    Paste(cloud, 0, 0, panel);
    DrawLegend(scale, legend, options_.view, panel);
    return panel;
  }

 private:
  const PictureOptions& options_;
  int width_;
  int height_;
  std::vector<size_t> shown_;
  std::vector<Splat> splats_;
  std::vector<StrokeField> strokes_;
};

std::vector<StrokeField> TurnStrokes(const std::vector<StrokeField>& strokes, const std::vector<size_t>& shown,
                                     const View& view) {
  std::vector<StrokeField> turned;
  for (const StrokeField& field : strokes) {
    turned.push_back({.name = field.name, .directions = {}});
    for (const size_t i : shown) turned.back().directions.push_back(view.Turn(field.directions[i]));
  }
  return turned;
}

}  // namespace

PanelGrid ArrangePanels(int panels, int width, int height) {
  PanelGrid best{1, panels};
  double most = 0.0;
  for (int columns = 1; columns <= panels; ++columns) {
    const int rows = (panels + columns - 1) / columns;
    const int panel_width = width / columns, panel_height = height / rows;
    const double room = std::min(panel_width - LegendWidth(panel_width, panel_height), panel_height);
    if (room <= most) continue;
    most = room;
    best = {columns, rows};
  }
  return best;
}

absl::StatusOr<Image> DrawPicture(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                                  const std::vector<Layer>& layers, const PictureOptions& options) {
  std::vector<size_t> shown;
  for (size_t i = 0; i < positions.size(); ++i) {
    if (IsFinite(positions[i])) shown.push_back(i);
  }
  if (shown.empty()) return absl::InvalidArgumentError("there is no point with a finite position to draw");
  const PanelGrid grid = ArrangePanels(static_cast<int>(layers.size()), options.width, options.height);
  const int width = options.width / grid.columns, height = options.height / grid.rows;
  if (std::min(width, height) < kMinPictureSide) {
    return absl::InvalidArgumentError(absl::StrCat(layers.size(), " panels of a picture of ", options.width, "x",
                                                   options.height, " would be of ", width, "x", height,
                                                   " pixels: each side must be at least ", kMinPictureSide));
  }
  const int legend_width = LegendWidth(width, height);
  if (absl::Status status = legend_width > 0 ? CheckFonts() : absl::OkStatus(); !status.ok()) return status;

  std::vector<Splat> splats =
      PlaceDiscs(MakeDiscs(shown, positions, normals, options.view), width - legend_width, height);
  std::vector<StrokeField> strokes = TurnStrokes(options.strokes, shown, options.view);
  PanelPainter painter(options, width, height, std::move(shown), std::move(splats), std::move(strokes));
  Image image(options.width, options.height, kPaper);
  for (size_t l = 0; l < layers.size(); ++l) {
    const int at = static_cast<int>(l);
    Paste(painter.Draw(layers[l]), at % grid.columns * width, at / grid.columns * height, image);
  }
  return image;
}

}  // namespace curv
