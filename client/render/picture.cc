#include "client/render/picture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "absl/status/status.h"
#include "client/render/legend.h"
#include "client/render/lettering.h"
#include "client/render/local_spacing.h"
#include "client/render/splats.h"

namespace curv {
namespace {

constexpr Color kPaper{1.0f, 1.0f, 1.0f};
constexpr int kOversampling = 2;
// Discs as wide as the way to the sixth neighbor leave no holes in a cloud that is spread at random.
constexpr int kSpacingRank = 6;
constexpr double kDiscSize = 1.0;
// A lonely point is not drawn larger than this many times the usual.
constexpr double kLargestDisc = 4.0;

bool IsFinite(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The direction of `normal` in the view, or toward the viewer if it has none.
Vec3 TurnNormal(const View& view, const Vec3& normal) {
  const double length = Norm(normal);
  return std::isfinite(length) && length > 0.0 ? view.Turn((1.0 / length) * normal) : Vec3{0, 0, 1};
}

}  // namespace

absl::StatusOr<Image> DrawPicture(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                                  const std::vector<double>& values, const PictureOptions& options) {
  std::vector<size_t> shown;
  std::vector<Vec3> turned;
  for (size_t i = 0; i < positions.size(); ++i) {
    if (!IsFinite(positions[i])) continue;
    shown.push_back(i);
    turned.push_back(options.view.Turn(positions[i]));
  }
  if (shown.empty()) return absl::InvalidArgumentError("there is no point with a finite position to draw");

  const ColorScale scale = options.scale ? *options.scale : ColorScale::ForValues(values);
  const int legend_width = LegendWidth(options.width, options.height);
  if (absl::Status status = legend_width > 0 ? CheckFonts() : absl::OkStatus(); !status.ok()) return status;
  const double picture_width = options.width - legend_width;
  const Framing framing = FitFrame(turned, picture_width, options.height, 0.05 * options.height);
  std::vector<double> spacing = LocalSpacing(turned, kSpacingRank);
  const double largest = kLargestDisc * std::max(Median(spacing), 1.0 / framing.scale);

  std::vector<Splat> splats(shown.size());
  LegendText legend{.title = options.title, .unit = options.unit};
  for (size_t s = 0; s < shown.size(); ++s) {
    const double value = values[shown[s]];
    legend.has_missing |= std::isnan(value);
    legend.has_below |= value < scale.low();
    legend.has_above |= value > scale.high();
    splats[s] = {.center = {0.5 * picture_width + framing.scale * (turned[s].x - framing.center_x),
                            0.5 * options.height - framing.scale * (turned[s].y - framing.center_y),
                            framing.scale * turned[s].z},
                 .normal = TurnNormal(options.view, normals[shown[s]]),
                 .radius = framing.scale * kDiscSize * std::min(spacing[s], largest),
                 .color = scale.ColorOf(value)};
  }
  Image image(options.width, options.height, kPaper);
  DrawSplats(splats, kOversampling, image);
  DrawLegend(scale, legend, options.view, image);
  return image;
}

}  // namespace curv
