// Chooses the values that a scale is labelled at.
#pragma once

#include <string>
#include <vector>

namespace curv {

struct Tick {
  double value;
  std::string label;  // of value / 10^exponent
};

struct Ticks {
  std::vector<Tick> ticks;
  int exponent = 0;  // of the power of ten that all labels are to be multiplied with
};

// Returns round values in [low, high], 3 to 9 of them in ascending order, whose labels have just the digits that tell
// them apart and a minus sign (U+2212) below zero. The exponent is 0 unless the labels would be very long.
// REQUIRES: low < high, both and their difference finite.
Ticks RoundTicks(double low, double high);

// Returns the exponent as text: superscript digits (U+2070 and others).
std::string Superscript(int exponent);

}  // namespace curv
