// From curvature to color.
#pragma once

#include <span>

#include "client/render/image.h"

namespace curv {

// The diverging map "cool to warm" (Moreland 2009): blue at -1, light grey at 0, red at 1; lightness changes evenly.
// `t` outside [-1, 1] is clamped. REQUIRES: t is not NaN.
Color DivergingColor(double t);

// What has no value.
inline constexpr Color kNoValueColor{0.45f, 0.45f, 0.45f};

// Colors of values from `low` to `high`, values outside are clamped. Where zero lies between, it is the map's middle,
// and each side has half of the map; otherwise the whole map is spread evenly.
class ColorScale {
 public:
  // REQUIRES: low < high, both finite.
  ColorScale(double low, double high) : low_(low), high_(high) {}

  // Symmetric about zero, wide enough for 98 of 100 of the finite values.
  static ColorScale ForValues(std::span<const double> values);

  double low() const { return low_; }
  double high() const { return high_; }
  // kNoValueColor for NaN.
  Color ColorOf(double value) const;

 private:
  double low_;
  double high_;
};

}  // namespace curv
