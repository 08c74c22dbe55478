#include "client/render/strokes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "client/render/canvas.h"

namespace curv {
namespace {

// In letter sizes.
constexpr double kSpacing = 1.7, kLength = 1.25, kLine = 0.11, kCasing = 0.24;
// Where the surface is seen from its edge, strokes would draw its outline.
constexpr double kLeastFacing = 0.25;
// Dark on light, and light on dark: both are seen on every color of the map.
struct Pen {
  Color casing;
  Color line;
};
constexpr std::array<Pen, 2> kPens = {{{{0.97f, 0.97f, 0.97f}, {0.10f, 0.10f, 0.10f}},  //
                                       {{0.10f, 0.10f, 0.10f}, {1.00f, 0.93f, 0.45f}}}};

bool IsDirection(const Vec3& v) {
  const double length = Norm(v);
  return std::isfinite(length) && length > 0.0;
}

// Chooses the splats that get strokes.
std::vector<size_t> ChooseSplats(const std::vector<Splat>& splats, const std::vector<StrokeField>& fields,
                                 const std::vector<float>& depths, double spacing, const Image& image) {
  constexpr size_t kNone = std::numeric_limits<size_t>::max();
  const auto columns = static_cast<size_t>(std::ceil(image.width / spacing));
  const auto rows = static_cast<size_t>(std::ceil(image.height / spacing));
  std::vector<size_t> chosen(columns * rows, kNone);
  std::vector<double> distances(chosen.size(), std::numeric_limits<double>::infinity());
  for (size_t s = 0; s < splats.size(); ++s) {
    const Vec3& center = splats[s].center;
    if (!(center.x >= 0.0 && center.x < image.width && center.y >= 0.0 && center.y < image.height)) continue;
    const size_t pixel =
        static_cast<size_t>(center.y) * static_cast<size_t>(image.width) + static_cast<size_t>(center.x);
    if (center.z < static_cast<double>(depths[pixel]) - splats[s].radius) continue;
    if (std::abs(splats[s].normal.z) < kLeastFacing) continue;
    if (std::none_of(fields.begin(), fields.end(), [s](const auto& f) { return IsDirection(f.directions[s]); }))
      continue;
    const double column = std::floor(center.x / spacing), row = std::floor(center.y / spacing);
    const size_t cell = static_cast<size_t>(row) * columns + static_cast<size_t>(column);
    const double distance = std::hypot(center.x - (column + 0.5) * spacing, center.y - (row + 0.5) * spacing);
    if (distance >= distances[cell]) continue;
    distances[cell] = distance;
    chosen[cell] = s;
  }
  std::erase(chosen, kNone);
  return chosen;
}

}  // namespace

void PaintStroke(size_t kind, double size, cairo_t* cairo) {
  const Pen& pen = kPens[kind % kPens.size()];
  cairo_set_line_cap(cairo, CAIRO_LINE_CAP_ROUND);
  cairo_set_line_width(cairo, std::max(2.0, kCasing * size));
  SetColor(pen.casing, cairo);
  cairo_stroke_preserve(cairo);
  cairo_set_line_width(cairo, std::max(1.0, kLine * size));
  SetColor(pen.line, cairo);
  cairo_stroke(cairo);
  cairo_set_line_cap(cairo, CAIRO_LINE_CAP_BUTT);
}

void DrawStrokes(const std::vector<Splat>& splats, const std::vector<StrokeField>& fields,
                 const std::vector<float>& depths, double size, Image& image) {
  if (fields.empty()) return;
  const std::vector<size_t> chosen = ChooseSplats(splats, fields, depths, kSpacing * size, image);
  Canvas canvas(0, image);
  for (size_t kind = 0; kind < fields.size(); ++kind) {
    for (const size_t s : chosen) {
      const Vec3& direction = fields[kind].directions[s];
      if (!IsDirection(direction)) continue;
      const Vec3 half = 0.5 * kLength * size * Normalized(direction);
      cairo_move_to(canvas.cairo(), splats[s].center.x - half.x, splats[s].center.y + half.y);
      cairo_line_to(canvas.cairo(), splats[s].center.x + half.x, splats[s].center.y - half.y);
      PaintStroke(kind, size, canvas.cairo());
    }
  }
}

}  // namespace curv
