#include "client/render/legend.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/render/axes.h"
#include "client/render/canvas.h"
#include "client/render/lettering.h"
#include "client/render/strokes.h"
#include "client/render/ticks.h"

namespace curv {
namespace {

constexpr Color kInk{0.15f, 0.15f, 0.15f};
constexpr Color kFaintInk{0.40f, 0.40f, 0.40f};

// Lengths are multiples of the letters' size.
constexpr double kWidth = 11.5, kBarWidth = 1.5, kMargin = 1.0, kLine = 1.35;
constexpr double kAxesHeight = 6.5, kMinBarHeight = 8.0;
constexpr double kEntryHeight = 1.6 * kLine;
constexpr int kMaxTitleLines = 4;

struct Box {
  double left;
  double right;
  double top;
  double bottom;
};

// Draws the legend from top to bottom.
class LegendPainter {
 public:
  LegendPainter(double size, double height, Canvas& canvas) : size_(size), height_(height), cairo_(canvas.cairo()) {}

  void Draw(const ColorScale& scale, const LegendText& text, const View& view) {
    const Ticks ticks = RoundTicks(scale.low(), scale.high());
    double top = DrawHeading(text, ticks.exponent) + (text.has_above ? kBarWidth : 0.4) * size_;
    double bottom = height_ - (kMargin + Entries(text) * kEntryHeight) * size_;
    bottom -= (text.has_below ? kBarWidth : 0.4) * size_;
    const bool has_axes = bottom - top > (kMinBarHeight + kAxesHeight) * size_;
    if (has_axes) bottom -= kAxesHeight * size_;
    if (bottom - top < size_) return;
    const Box bar{Left(), Left() + kBarWidth * size_, std::floor(top) + 0.5, std::floor(bottom) + 0.5};
    FillBar(bar, scale);
    FrameBar(bar, text, scale);
    DrawTicks(bar, ticks.ticks, scale);
    double y = bar.bottom + (text.has_below ? kBarWidth : 0.0) * size_;
    if (text.has_missing) DrawMissing(y += kEntryHeight * size_);
    for (size_t s = 0; s < text.strokes.size(); ++s) DrawStroke(s, text.strokes[s], y += kEntryHeight * size_);
    if (has_axes) DrawAxes(view, Left() + 2.2 * size_, 0.5 * (y + height_), size_, cairo_);
  }

 private:
  static double Entries(const LegendText& text) {
    return static_cast<double>(text.strokes.size() + (text.has_missing ? 1 : 0));
  }

  double Left() const { return std::floor(kMargin * size_) + 0.5; }

  // Returns where the heading ends.
  double DrawHeading(const LegendText& text, int exponent) {
    double y = (0.06 * height_ > 2.0 * size_ ? 0.06 * height_ : kMargin * size_) + 0.8 * size_;
    SetColor(kInk, cairo_);
    constexpr double kTextWidth = kWidth - 1.5 * kMargin;
    const TextBlock title(text.title, size_, kTextWidth * size_, kMaxTitleLines, cairo_);
    title.Draw(Left(), y, kLine * size_);
    y += title.line_count() * kLine * size_;
    const std::string power = exponent == 0 ? "" : absl::StrCat("\u00d7 10", Superscript(exponent));
    const std::string below = absl::StrCat(power, power.empty() || text.unit.empty() ? "" : "  ", text.unit);
    if (!below.empty()) {
      SetColor(kFaintInk, cairo_);
      TextBlock(below, 0.85 * size_, kTextWidth * size_, 1, cairo_).Draw(Left(), y);
      y += kLine * size_;
    }
    return y - 0.6 * size_;
  }

  void FillBar(const Box& bar, const ColorScale& scale) {
    cairo_set_antialias(cairo_, CAIRO_ANTIALIAS_NONE);
    for (double y = std::floor(bar.top); y < bar.bottom; ++y) {
      const double t = std::clamp((bar.bottom - y) / (bar.bottom - bar.top), 0.0, 1.0);
      SetColor(scale.ColorOf(scale.low() + t * (scale.high() - scale.low())), cairo_);
      cairo_rectangle(cairo_, std::floor(bar.left), y, std::ceil(bar.right) - std::floor(bar.left), 1.0);
      cairo_fill(cairo_);
    }
    cairo_set_antialias(cairo_, CAIRO_ANTIALIAS_DEFAULT);
  }

  // A point at an end says that values go on beyond it.
  void FrameBar(const Box& bar, const LegendText& text, const ColorScale& scale) {
    const auto point = [&](double end, double tip, double value) {
      cairo_move_to(cairo_, bar.left, end);
      cairo_line_to(cairo_, 0.5 * (bar.left + bar.right), tip);
      cairo_line_to(cairo_, bar.right, end);
      SetColor(scale.ColorOf(value), cairo_);
      cairo_fill(cairo_);
    };
    const double top_tip = bar.top - (text.has_above ? 0.8 * kBarWidth * size_ : 0.0);
    const double bottom_tip = bar.bottom + (text.has_below ? 0.8 * kBarWidth * size_ : 0.0);
    if (text.has_above) point(bar.top, top_tip, scale.high());
    if (text.has_below) point(bar.bottom, bottom_tip, scale.low());
    const double middle = 0.5 * (bar.left + bar.right);
    const std::array<std::pair<double, double>, 6> corners = {{{bar.left, bar.top},
                                                               {middle, top_tip},
                                                               {bar.right, bar.top},
                                                               {bar.right, bar.bottom},
                                                               {middle, bottom_tip},
                                                               {bar.left, bar.bottom}}};
    for (const auto& [x, y] : corners) cairo_line_to(cairo_, x, y);
    cairo_close_path(cairo_);
    Stroke(1.0, kInk);
  }

  void DrawTicks(const Box& bar, const std::vector<Tick>& ticks, const ColorScale& scale) {
    std::vector<TextBlock> labels;
    double widest = 0.0;
    for (const Tick& tick : ticks) widest = std::max(widest, labels.emplace_back(tick.label, size_, cairo_).width());
    for (size_t i = 0; i < ticks.size(); ++i) {
      const Tick& tick = ticks[i];
      const double t = std::clamp((tick.value - scale.low()) / (scale.high() - scale.low()), 0.0, 1.0);
      const double y = std::round(bar.bottom - t * (bar.bottom - bar.top)) + 0.5;
      cairo_move_to(cairo_, bar.right, std::clamp(y, bar.top, bar.bottom));
      cairo_rel_line_to(cairo_, 0.35 * size_, 0.0);
      Stroke(1.0, kInk);
      // Numbers line up at their last digits. Half the height of a digit is 0.36.
      labels[i].Draw(bar.right + 0.7 * size_ + widest - labels[i].width(), y + 0.36 * size_);
    }
  }

  void DrawMissing(double y) {
    cairo_rectangle(cairo_, Left(), y - 0.85 * size_, kBarWidth * size_, size_);
    SetColor(kNoValueColor, cairo_);
    cairo_fill(cairo_);
    NameEntry("no value", y);
  }

  void DrawStroke(size_t kind, const std::string& name, double y) {
    cairo_move_to(cairo_, Left(), y - 0.35 * size_);
    cairo_rel_line_to(cairo_, kBarWidth * size_, 0.0);
    PaintStroke(kind, size_, cairo_);
    NameEntry(name, y);
  }

  void NameEntry(const std::string& name, double y) {
    SetColor(kInk, cairo_);
    TextBlock(name, 0.85 * size_, cairo_).Draw(Left() + (kBarWidth + 0.7) * size_, y - 0.05 * size_);
  }

  void Stroke(double width, const Color& color) {
    cairo_set_line_width(cairo_, width);
    SetColor(color, cairo_);
    cairo_stroke(cairo_);
  }

  double size_;
  double height_;
  cairo_t* cairo_;
};

}  // namespace

double LetterSize(int image_width, int image_height) {
  return std::max(11.0, 0.0215 * std::min<double>(image_height, 0.85 * image_width));
}

int LegendWidth(int image_width, int image_height) {
  const double size = LetterSize(image_width, image_height);
  const double width = std::ceil(kWidth * size);
  return width > 0.45 * image_width || image_height < 1.2 * kMinBarHeight * size ? 0 : static_cast<int>(width);
}

void DrawLegend(const ColorScale& scale, const LegendText& text, const View& view, Image& image) {
  const int width = LegendWidth(image.width, image.height);
  if (width == 0) return;
  Canvas canvas(image.width - width, image);
  LegendPainter(LetterSize(image.width, image.height), image.height, canvas).Draw(scale, text, view);
}

}  // namespace curv
