#include "client/render/lettering.h"

#include <fontconfig/fontconfig.h>
#include <pango/pangocairo.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>

#include "absl/strings/str_cat.h"

namespace curv {
namespace {

constexpr char kFamilies[] = "DejaVu Sans, sans-serif";
constexpr char kReplacement[] = "\xef\xbf\xbd";  // U+FFFD

struct Release {
  void operator()(FcPattern* pattern) const { FcPatternDestroy(pattern); }
  void operator()(PangoContext* context) const { g_object_unref(context); }
  void operator()(PangoFontDescription* description) const { pango_font_description_free(description); }
  void operator()(PangoLayoutIter* iter) const { pango_layout_iter_free(iter); }
  void operator()(cairo_font_options_t* options) const { cairo_font_options_destroy(options); }
};
template <typename T>
using Owned = std::unique_ptr<T, Release>;

// `text` with U+FFFD for what is no character that can be shown.
std::string Clean(const std::string& text) {
  std::string clean;
  for (size_t at = 0; at < text.size();) {
    FcChar32 code = 0;
    const int length = FcUtf8ToUcs4(reinterpret_cast<const FcChar8*>(text.data() + at), &code,
                                    static_cast<int>(std::min<size_t>(8, text.size() - at)));
    const bool surrogate = code >= 0xd800 && code < 0xe000;
    const bool control = code < 0x20 || (code >= 0x7f && code < 0xa0);
    if (length < 1 || control || surrogate || code > 0x10ffff) {
      clean += kReplacement;
    } else {
      clean += text.substr(at, static_cast<size_t>(length));
    }
    at += static_cast<size_t>(std::max(1, length));
  }
  return clean;
}

Owned<PangoContext> MakeContext(PangoFontMap* fonts) {
  Owned<PangoContext> context(pango_font_map_create_context(fonts));
  const Owned<cairo_font_options_t> options(cairo_font_options_create());
  cairo_font_options_set_antialias(options.get(), CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
  pango_cairo_context_set_font_options(context.get(), options.get());
  pango_context_set_round_glyph_positions(context.get(), FALSE);
  return context;
}

// A new layout of one paragraph, which the caller owns.
PangoLayout* LayOut(const std::string& text, double size) {
  const Owned<PangoContext> context = MakeContext(pango_cairo_font_map_get_default());
  PangoLayout* const layout = pango_layout_new(context.get());
  const Owned<PangoFontDescription> font(pango_font_description_from_string(kFamilies));
  pango_font_description_set_absolute_size(font.get(), size * PANGO_SCALE);
  pango_layout_set_font_description(layout, font.get());
  pango_layout_set_single_paragraph_mode(layout, TRUE);
  pango_layout_set_text(layout, Clean(text).c_str(), -1);
  return layout;
}

double LineWidth(PangoLayoutLine* line) {
  PangoRectangle extents;
  pango_layout_line_get_extents(line, nullptr, &extents);
  return extents.width / static_cast<double>(PANGO_SCALE);
}

}  // namespace

absl::Status CheckFonts() {
  const Owned<FcPattern> wanted(FcPatternCreate());
  FcConfigSubstitute(nullptr, wanted.get(), FcMatchPattern);
  FcDefaultSubstitute(wanted.get());
  FcResult result;
  const Owned<FcPattern> found(FcFontMatch(nullptr, wanted.get(), &result));
  FcChar8* file = nullptr;
  if (found && FcPatternGetString(found.get(), FC_FILE, 0, &file) == FcResultMatch) return absl::OkStatus();
  return absl::FailedPreconditionError(
      "no font is installed, which the scale bar of a picture needs: install one, for example the package "
      "fonts-dejavu-core");
}

void TextBlock::Release::operator()(PangoLayout* layout) const { g_object_unref(layout); }

TextBlock::TextBlock(const std::string& text, double size, cairo_t* cairo)
    : cairo_(cairo), layout_(LayOut(text, size)) {}

TextBlock::TextBlock(const std::string& text, double size, double width, int max_lines, cairo_t* cairo)
    : TextBlock(text, size, cairo) {
  pango_layout_set_width(layout_.get(), std::max(1, static_cast<int>(std::floor(width * PANGO_SCALE))));
  pango_layout_set_wrap(layout_.get(), PANGO_WRAP_WORD_CHAR);
  pango_layout_set_height(layout_.get(), -max_lines);
  pango_layout_set_ellipsize(layout_.get(), PANGO_ELLIPSIZE_END);
}

double TextBlock::width() const {
  double widest = 0.0;
  for (int l = 0; l < line_count(); ++l) {
    widest = std::max(widest, LineWidth(pango_layout_get_line_readonly(layout_.get(), l)));
  }
  return widest;
}

int TextBlock::line_count() const { return pango_layout_get_line_count(layout_.get()); }

void TextBlock::Draw(double x, double y, double spacing) const {
  const double widest = width();
  for (int l = 0; l < line_count(); ++l) {
    PangoLayoutLine* const line = pango_layout_get_line_readonly(layout_.get(), l);
    const bool from_right = pango_layout_line_get_resolved_direction(line) == PANGO_DIRECTION_RTL;
    cairo_move_to(cairo_, x + (from_right ? widest - LineWidth(line) : 0.0), y + l * spacing);
    pango_cairo_show_layout_line(cairo_, line);
  }
}

std::string LetteringProblem(const std::string& text) {
  // Laid out, a character that no font has is a glyph that names it.
  const std::unique_ptr<PangoLayout, void (*)(gpointer)> layout(LayOut(text, 16.0), g_object_unref);
  std::set<gunichar> missing;
  const Owned<PangoLayoutIter> iter(pango_layout_get_iter(layout.get()));
  do {
    const PangoLayoutRun* const run = pango_layout_iter_get_run_readonly(iter.get());
    for (int g = 0; run != nullptr && g < run->glyphs->num_glyphs; ++g) {
      const PangoGlyph glyph = run->glyphs->glyphs[g].glyph;
      if ((glyph & PANGO_GLYPH_UNKNOWN_FLAG) != 0) missing.insert(glyph & ~PANGO_GLYPH_UNKNOWN_FLAG);
    }
  } while (pango_layout_iter_next_run(iter.get()) == TRUE);
  if (missing.empty()) return "";
  std::string characters;
  for (const gunichar code : missing) {
    char bytes[6];
    characters.append(bytes, static_cast<size_t>(g_unichar_to_utf8(code, bytes)));
  }
  return absl::StrCat("no installed font has all of \"", text, "\": ", characters, " will be boxes. Install a font of ",
                      "that language, for example one of the packages fonts-noto");
}

}  // namespace curv
