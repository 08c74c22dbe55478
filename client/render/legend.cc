#include "client/render/legend.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "client/render/lettering.h"

namespace curv {
namespace {

constexpr Color kInk{0.15f, 0.15f, 0.15f};

// 1, 2 or 5 times a power of ten, so that about five steps fit.
double RoundStep(double span) {
  const double rough = span / 5.0;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double leading = rough / power;
  return power * (leading < 1.5 ? 1.0 : leading < 3.5 ? 2.0 : leading < 7.5 ? 5.0 : 10.0);
}

std::string Label(double value, double step, double largest) {
  char text[40];
  if (largest >= 1e5 || step < 1e-5) {
    const int digits = std::max(0, static_cast<int>(std::floor(std::log10(largest)) - std::floor(std::log10(step))));
    std::snprintf(text, sizeof(text), "%.*e", value == 0.0 ? 0 : digits, value);
    return value == 0.0 ? "0" : text;
  }
  const int digits = std::max(0, static_cast<int>(-std::floor(std::log10(step * (1.0 + 1e-9)))));
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  return text;
}

// Lengths of the legend's parts, all in proportion to the picture.
struct Measures {
  explicit Measures(int image_height)
      : size(std::max(7.0, 0.0165 * image_height)), bar_width(1.9 * size), width(13.0 * size) {}
  double size;  // of capital letters
  double bar_width;
  double width;
};

void FillRows(double left, double right, double top, double bottom, const ColorScale& scale, Image& image) {
  for (int y = static_cast<int>(top); y < static_cast<int>(bottom); ++y) {
    const double t = (bottom - (y + 0.5)) / (bottom - top);
    const Color color = scale.ColorOf(scale.low() + t * (scale.high() - scale.low()));
    for (int x = static_cast<int>(left); x < static_cast<int>(right); ++x) image.at(x, y) = color;
  }
}

void Frame(double left, double right, double top, double bottom, Image& image) {
  DrawLine(left, top, right, top, 1.0, kInk, image);
  DrawLine(left, bottom, right, bottom, 1.0, kInk, image);
  DrawLine(left, top, left, bottom, 1.0, kInk, image);
  DrawLine(right, top, right, bottom, 1.0, kInk, image);
}

}  // namespace

std::vector<Tick> RoundTicks(double low, double high) {
  const double step = RoundStep(high - low);
  const double largest = std::max(std::abs(low), std::abs(high));
  std::vector<Tick> ticks;
  // The margin lets ends that are round but for rounding take part.
  const double margin = 1e-9 * (high - low);
  for (double i = std::ceil((low - margin) / step); i * step <= high + margin && ticks.size() < 20; ++i) {
    const double value = i == 0.0 ? 0.0 : i * step;
    ticks.push_back({value, Label(value, step, largest)});
  }
  return ticks;
}

int LegendWidth(int image_height) { return static_cast<int>(std::ceil(Measures(image_height).width)); }

void DrawLegend(const ColorScale& scale, const LegendText& text, Image& image) {
  const Measures m(image.height);
  const double left = std::floor(image.width - m.width + m.size);
  const double line = 1.9 * m.size;
  double y = std::floor(0.13 * image.height);
  for (const std::string& title : text.title) {
    DrawText(title, left, y, m.size, kInk, image);
    y += line;
  }
  const double right = std::floor(left + m.bar_width);
  const double top = std::floor(y);
  const double bottom = std::floor(0.87 * image.height);
  if (bottom <= top || left < 0) return;  // no room in so small a picture
  FillRows(left, right, top, bottom, scale, image);
  Frame(left, right, top, bottom, image);
  for (const Tick& tick : RoundTicks(scale.low(), scale.high())) {
    const double t = std::clamp((tick.value - scale.low()) / (scale.high() - scale.low()), 0.0, 1.0);
    const double at = bottom - t * (bottom - top);
    DrawLine(right, at, right + 0.5 * m.size, at, 1.0, kInk, image);
    // Numbers line up at their digits, whatever their sign.
    const double indent = tick.label[0] == '-' ? 0.0 : TextWidth("-0", m.size) - TextWidth("0", m.size);
    DrawText(tick.label, right + m.size + indent, at + 0.5 * m.size, m.size, kInk, image);
  }
  if (!text.has_missing) return;
  const double swatch = bottom + line;
  for (double dy = 0; dy < m.size; ++dy)
    DrawLine(left, swatch + dy, left + m.size, swatch + dy, 1.0, kNoValueColor, image);
  DrawText("no value", left + m.bar_width, swatch + m.size, m.size, kInk, image);
}

}  // namespace curv
