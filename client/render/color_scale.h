// Turns values into colors.
#pragma once

#include <span>

#include "client/render/image.h"

namespace curv {

// Returns a color of the diverging map "cool to warm" (Moreland 2009): blue at -1, light grey at 0, red at 1, with
// lightness that changes evenly. `t` outside [-1, 1] is clamped. REQUIRES: t is not NaN.
Color DivergingColor(double t);

// The color of points that have no value.
inline constexpr Color kNoValueColor{0.45f, 0.45f, 0.45f};

// Spreads the map over the values from `low` to `high`; values outside are clamped. Where zero lies between, it has the
// map's middle, and each side has half of the map; otherwise the map is spread evenly.
class ColorScale {
 public:
  // REQUIRES: low < high, both and their difference finite.
  ColorScale(double low, double high) : low_(low), high_(high) {}

  // Returns a scale that is symmetric about zero and wide enough for 98 of 100 of the finite values (values above half
  // of the largest number apart); from -1 to 1 if there is none.
  static ColorScale ForValues(std::span<const double> values);

  double low() const { return low_; }
  double high() const { return high_; }
  // Returns the color of a value, kNoValueColor for NaN.
  Color ColorOf(double value) const;

 private:
  double low_;
  double high_;
};

}  // namespace curv
