#include "core/scale/line_distance.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace curvd {
namespace {

// A neighbor lies on the line through the point and its nearest one if the sine of the angle between them is at most
// this. Points lie on lines if so many of the nearest do, and the first that does not is so many times as far away as
// the last of these.
constexpr float kSineOnLine = 0.26f;
constexpr size_t kLeastOnLine = 4;
constexpr float kLeastGap = 1.25f;

using Offset = std::array<float, 3>;

float SquaredLength(const Offset& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

Offset Cross(const Offset& a, const Offset& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

double LineDistance(double largest_radius, const PilotScratch& s) {
  const NeighborArrays& n = s.neighbors;
  size_t on_line = 0;
  Offset nearest{};
  float last_squared = 0.0f;  // of those that must lie on the line
  for (const uint32_t j : s.order) {
    if (!(s.squared[j] > 0.0f) || IsCopy(s.ids[j])) continue;
    const Offset offset = {n.dx[j], n.dy[j], n.dz[j]};
    if (on_line == 0) nearest = offset;
    const float squared_sine = SquaredLength(Cross(nearest, offset)) / (SquaredLength(nearest) * s.squared[j]);
    if (squared_sine > kSineOnLine * kSineOnLine) {
      const bool are_lines = on_line >= kLeastOnLine && s.squared[j] > kLeastGap * kLeastGap * last_squared;
      const double distance = are_lines ? std::sqrt(double{s.squared[j]}) : 0.0;
      return largest_radius >= LeastRadiusOverLines(kRegressionMethod) * distance ? distance : 0.0;
    }
    if (++on_line == kLeastOnLine) last_squared = s.squared[j];
  }
  return 0.0;
}

}  // namespace curvd
