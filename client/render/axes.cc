#include "client/render/axes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "client/render/canvas.h"
#include "client/render/lettering.h"

namespace curv {
namespace {

constexpr Color kNearInk{0.15f, 0.15f, 0.15f}, kFarInk{0.62f, 0.62f, 0.62f};
// In letter sizes.
constexpr double kLength = 1.7, kHead = 0.45, kRing = 0.32, kLine = 0.09, kNameGap = 0.55;

struct Axis {
  const char* name;
  Vec3 direction;  // in coordinates of the view

  // How long a unit of the axis is in the picture.
  double Share() const { return std::hypot(direction.x, direction.y); }
  bool IsOnEnd() const { return Share() < 0.1; }
  // An axis that lies in the picture points away from nobody.
  bool IsFar() const { return direction.z < -1e-9; }
};

// Each of these draws around the origin, in letter sizes.
void DrawArrow(const Axis& axis, cairo_t* cairo) {
  const double length = kLength * axis.Share();
  cairo_save(cairo);
  cairo_rotate(cairo, std::atan2(-axis.direction.y, axis.direction.x));
  cairo_move_to(cairo, 0.0, 0.0);
  cairo_line_to(cairo, std::max(0.0, length - 0.8 * kHead), 0.0);
  cairo_stroke(cairo);
  cairo_move_to(cairo, length, 0.0);
  cairo_line_to(cairo, length - kHead, 0.38 * kHead);
  cairo_line_to(cairo, length - kHead, -0.38 * kHead);
  cairo_fill(cairo);
  cairo_restore(cairo);
}

void DrawRing(const Axis& axis, cairo_t* cairo) {
  constexpr double kTurn = 2.0 * std::numbers::pi, kReach = kRing * std::numbers::sqrt2 / 2.0;
  cairo_new_sub_path(cairo);
  cairo_arc(cairo, 0.0, 0.0, kRing, 0.0, kTurn);
  if (axis.IsFar()) {
    for (const double side : {-1.0, 1.0}) {
      cairo_move_to(cairo, -kReach, side * kReach);
      cairo_line_to(cairo, kReach, -side * kReach);
    }
  }
  cairo_stroke(cairo);
  if (axis.IsFar()) return;
  cairo_arc(cairo, 0.0, 0.0, 0.3 * kRing, 0.0, kTurn);
  cairo_fill(cairo);
}

// The name stands beyond the tip, or to the lower left of a ring.
void DrawName(const Axis& axis, cairo_t* cairo) {
  const double reach = kLength + kNameGap / std::max(axis.Share(), 0.1);
  const double x = axis.IsOnEnd() ? -0.75 : axis.direction.x * reach;
  const double y = axis.IsOnEnd() ? 0.75 : -axis.direction.y * reach;
  const TextBlock name(axis.name, 0.85, cairo);
  name.Draw(x - 0.5 * name.width(), y + 0.23);
}

}  // namespace

void DrawAxes(const View& view, double x, double y, double size, cairo_t* cairo) {
  std::array<Axis, 3> axes = {{{"x", view.Turn({1, 0, 0})}, {"y", view.Turn({0, 1, 0})}, {"z", view.Turn({0, 0, 1})}}};
  std::sort(axes.begin(), axes.end(), [](const Axis& a, const Axis& b) { return a.direction.z < b.direction.z; });
  cairo_save(cairo);
  cairo_translate(cairo, x, y);
  cairo_scale(cairo, size, size);
  cairo_set_line_width(cairo, std::max(1.0 / size, kLine));
  for (const Axis& axis : axes) {
    SetColor(axis.IsFar() ? kFarInk : kNearInk, cairo);
    axis.IsOnEnd() ? DrawRing(axis, cairo) : DrawArrow(axis, cairo);
    DrawName(axis, cairo);
  }
  cairo_restore(cairo);
}

}  // namespace curv
