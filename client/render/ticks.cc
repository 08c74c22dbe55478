#include "client/render/ticks.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace curv {
namespace {

constexpr char kMinus[] = "\xe2\x88\x92";

// Returns 1, 2 or 5 times a power of ten, so that about five steps fit.
double RoundStep(double span) {
  const double rough = span / 5.0;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double leading = rough / power;
  return power * (leading < 1.5 ? 1.0 : leading < 3.5 ? 2.0 : leading < 7.5 ? 5.0 : 10.0);
}

// The exponent of the power of ten just below a number; 0 if the labels of a scale up to it need none.
int CommonExponent(double largest, double step) {
  const bool is_short = largest < 1e5 && step > 0.99e-4;
  return is_short ? 0 : static_cast<int>(std::floor(std::log10(largest) + 1e-9));
}

std::string Label(double mantissa, int digits) {
  return absl::StrCat(mantissa < 0.0 ? kMinus : "", absl::StrFormat("%.*f", digits, std::abs(mantissa)));
}

}  // namespace

Ticks RoundTicks(double low, double high) {
  const double step = RoundStep(high - low);
  Ticks result{.ticks = {}, .exponent = CommonExponent(std::max(std::abs(low), std::abs(high)), step)};
  const double unit = std::pow(10.0, result.exponent);
  const int digits = std::clamp(static_cast<int>(-std::floor(std::log10(step / unit * (1.0 + 1e-9)))), 0, 15);
  // The margin lets ends that are round but for rounding take part.
  const double margin = 1e-9 * (high - low);
  for (double i = std::ceil((low - margin) / step); i * step <= high + margin && result.ticks.size() < 20; ++i) {
    const double value = i == 0.0 ? 0.0 : i * step;
    result.ticks.push_back({value, Label(value / unit, digits)});
  }
  return result;
}

std::string Superscript(int exponent) {
  static constexpr const char* kDigits[] = {"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                            "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  std::string text = exponent < 0 ? "\u207b" : "";
  for (const char digit : absl::StrCat(std::abs(exponent))) text += kDigits[digit - '0'];
  return text;
}

}  // namespace curv
