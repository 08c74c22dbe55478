#include "client/render/lettering.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace curv {
namespace {

// The strokes of a glyph, separated by blanks: each a polyline of corners, two digits x and y a corner. The baseline is
// at y = 2, small letters end at 6, capitals and digits at 8, descenders at 0.
constexpr std::pair<char, std::string_view> kGlyphs[] = {
    {'0', "122233372818070312"},
    {'1', "071812"},
    {'2', "071828373602 0232"},
    {'3', "0718283736253433221203 1525"},
    {'4', "22280434"},
    {'5', "380805253433221203"},
    {'6', "372818070312223334251504"},
    {'7', "083812"},
    {'8', "15253637281807061504031222333425"},
    {'9', "362515060718283733221203"},
    {'-', "0535"},
    {'+', "0545 2327"},
    {'.', "0202"},
    {',', "1201"},
    {':', "0303 0606"},
    {'/', "0138"},
    {'(', "18070312"},
    {')', "08171302"},
    {'=', "0434 0636"},
    {'_', "0131"},
    {'G', "37281807031222333525"},
    {'H', "0802 3832 0535"},
    {'a', "3526160503122233 3632"},
    {'b', "0802 0516263533221203"},
    {'c', "3526160503122233"},
    {'d', "3832 3526160503122233"},
    {'e', "04343526160503122233"},
    {'f', "38281712 0626"},
    {'g', "3631201001 3526160503122233"},
    {'h', "0802 0516263532"},
    {'i', "0602 0808"},
    {'j', "161100 1818"},
    {'k', "0802 3603 1432"},
    {'l', "0802"},
    {'m', "0602 05162522 25364542"},
    {'n', "0602 0516263532"},
    {'o', "122233352616050312"},
    {'p', "0600 0516263533221203"},
    {'q', "3630 3526160503122233"},
    {'r', "0602 051626"},
    {'s', "35261605142433221203"},
    {'t', "18132232 0626"},
    {'u', "0603122233 3632"},
    {'v', "062246"},
    {'w', "0612263246"},
    {'x', "0632 0236"},
    {'y', "0622 4610"},
    {'z', "06360232"},
};
constexpr double kCapitalUnits = 6.0;
constexpr double kGapUnits = 1.7;
constexpr double kBlankUnits = 1.2;

std::string_view StrokesOf(char c) {
  for (const auto& [glyph, strokes] : kGlyphs) {
    if (glyph == c) return strokes;
  }
  return "";
}

double GlyphUnits(std::string_view strokes) {
  if (strokes.empty()) return kBlankUnits;
  char widest = '0';
  for (size_t i = 0; i < strokes.size(); ++i) {
    if (strokes[i] == ' ') continue;
    widest = std::max(widest, strokes[i]);
    ++i;  // y
  }
  return widest - '0';
}

void DrawGlyph(std::string_view strokes, double x, double y, double unit, const Color& color, Image& image) {
  const double width = std::max(1.0, 0.75 * unit);
  double from_x = 0.0, from_y = 0.0;
  bool pen_down = false;
  for (size_t i = 0; i < strokes.size(); ++i) {
    if (strokes[i] == ' ') {
      pen_down = false;
      continue;
    }
    const double to_x = x + unit * (strokes[i] - '0');
    const double to_y = y - unit * (strokes[++i] - '2');
    if (pen_down) DrawLine(from_x, from_y, to_x, to_y, width, color, image);
    from_x = to_x;
    from_y = to_y;
    pen_down = true;
  }
}

}  // namespace

double TextWidth(std::string_view text, double size) {
  double units = 0.0;
  for (const char c : text) units += GlyphUnits(StrokesOf(c)) + kGapUnits;
  return std::max(0.0, units - kGapUnits) * size / kCapitalUnits;
}

void DrawText(std::string_view text, double x, double y, double size, const Color& color, Image& image) {
  const double unit = size / kCapitalUnits;
  for (const char c : text) {
    const std::string_view strokes = StrokesOf(c);
    DrawGlyph(strokes, x, y, unit, color, image);
    x += (GlyphUnits(strokes) + kGapUnits) * unit;
  }
}

void DrawLine(double x0, double y0, double x1, double y1, double width, const Color& color, Image& image) {
  const double reach = 0.5 * width + 1.0;
  const int left = std::max(0, static_cast<int>(std::floor(std::min(x0, x1) - reach)));
  const int right = std::min(image.width - 1, static_cast<int>(std::ceil(std::max(x0, x1) + reach)));
  const int top = std::max(0, static_cast<int>(std::floor(std::min(y0, y1) - reach)));
  const int bottom = std::min(image.height - 1, static_cast<int>(std::ceil(std::max(y0, y1) + reach)));
  const double dx = x1 - x0, dy = y1 - y0, squared = dx * dx + dy * dy;
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const double px = x + 0.5 - x0, py = y + 0.5 - y0;
      const double along = squared > 0.0 ? std::clamp((px * dx + py * dy) / squared, 0.0, 1.0) : 0.0;
      const double distance = std::hypot(px - along * dx, py - along * dy);
      const float cover = static_cast<float>(std::clamp(0.5 * width + 0.5 - distance, 0.0, 1.0));
      image.at(x, y) = (1.0f - cover) * image.at(x, y) + cover * color;
    }
  }
}

}  // namespace curv
