#include "client/render/color_scale.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace curv {
namespace {

// CIELAB in polar form about the grey axis: magnitude, saturation angle, hue angle.
struct Msh {
  double magnitude;
  double saturation;
  double hue;
};

double FromLinear(double channel) {
  return channel <= 0.0031308 ? 12.92 * channel : 1.055 * std::pow(channel, 1.0 / 2.4) - 0.055;
}

double InverseLabCurve(double t) {
  constexpr double kKnee = 6.0 / 29.0;
  return t > kKnee ? t * t * t : 3.0 * kKnee * kKnee * (t - 4.0 / 29.0);
}

// Through CIELAB and CIE XYZ (white D65) to sRGB.
Color ToColor(const Msh& msh) {
  const double lightness = msh.magnitude * std::cos(msh.saturation);
  const double chroma = msh.magnitude * std::sin(msh.saturation);
  const double level = (lightness + 16.0) / 116.0;
  const double x = 0.95047 * InverseLabCurve(level + chroma * std::cos(msh.hue) / 500.0);
  const double y = InverseLabCurve(level);
  const double z = 1.08883 * InverseLabCurve(level - chroma * std::sin(msh.hue) / 200.0);
  return {static_cast<float>(std::clamp(FromLinear(3.2406 * x - 1.5372 * y - 0.4986 * z), 0.0, 1.0)),
          static_cast<float>(std::clamp(FromLinear(-0.9689 * x + 1.8758 * y + 0.0415 * z), 0.0, 1.0)),
          static_cast<float>(std::clamp(FromLinear(0.0557 * x - 0.2040 * y + 1.0570 * z), 0.0, 1.0))};
}

// From the light grey of the middle (0) to a saturated end (1). The hue of the grey is turned past the end's, so that
// the way between keeps its distance from grey (Moreland 2009, section 5).
Color Between(const Msh& end, double hue_turn, double t) {
  constexpr double kMiddleMagnitude = 88.0;
  return ToColor(
      {kMiddleMagnitude + t * (end.magnitude - kMiddleMagnitude), t * end.saturation, end.hue + (1.0 - t) * hue_turn});
}

Color ExactDivergingColor(double t) {
  constexpr Msh kBlue{80.0, 1.08, -1.1};
  constexpr Msh kRed{80.0, 1.08, 0.5};
  return t < 0.0 ? Between(kBlue, -0.561, -t) : Between(kRed, 0.561, t);
}

}  // namespace

Color DivergingColor(double t) {
  constexpr int kSteps = 512;  // on either side
  static const auto* const table = [] {
    auto* colors = new std::array<Color, 2 * kSteps + 1>;
    for (int i = 0; i <= 2 * kSteps; ++i) {
      (*colors)[static_cast<size_t>(i)] = ExactDivergingColor(static_cast<double>(i - kSteps) / kSteps);
    }
    return colors;
  }();
  return (*table)[static_cast<size_t>(std::lround((std::clamp(t, -1.0, 1.0) + 1.0) * kSteps))];
}

ColorScale ColorScale::ForValues(std::span<const double> values) {
  std::vector<double> sizes;
  for (const double value : values) {
    if (std::isfinite(value)) sizes.push_back(std::abs(value));
  }
  if (sizes.empty()) return ColorScale(-1.0, 1.0);
  const auto rank = sizes.begin() + static_cast<ptrdiff_t>(0.98 * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), rank, sizes.end());
  // The width of the scale is to be finite, too.
  const double size = *rank > 0.0 ? std::min(*rank, 0.5 * std::numeric_limits<double>::max()) : 1.0;
  return ColorScale(-size, size);
}

Color ColorScale::ColorOf(double value) const {
  if (std::isnan(value)) return kNoValueColor;
  if (low_ < 0.0 && high_ > 0.0) return DivergingColor(value < 0.0 ? -value / low_ : value / high_);
  return DivergingColor(2.0 * (value - low_) / (high_ - low_) - 1.0);
}

}  // namespace curv
