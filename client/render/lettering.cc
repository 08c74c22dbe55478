#include "client/render/lettering.h"

#include <cairo-ft.h>
#include <fontconfig/fontconfig.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"

namespace curv {
namespace {

constexpr char kReplacement[] = "\xef\xbf\xbd";  // U+FFFD
constexpr char kEllipsis[] = "\xe2\x80\xa6";

struct CodeRange {
  FcChar32 first;
  FcChar32 last;
};
// Hebrew to Arabic Extended-A; Devanagari to Myanmar; Khmer and Mongolian; presentation forms of Hebrew and Arabic.
constexpr CodeRange kShapedScripts[] = {
    {0x0590, 0x08ff}, {0x0900, 0x109f}, {0x1780, 0x18af}, {0xfb1d, 0xfdff}, {0xfe70, 0xfeff}};

struct Release {
  void operator()(FcPattern* pattern) const { FcPatternDestroy(pattern); }
  void operator()(FcCharSet* characters) const { FcCharSetDestroy(characters); }
  void operator()(cairo_font_options_t* options) const { cairo_font_options_destroy(options); }
  void operator()(cairo_font_face_t* face) const { cairo_font_face_destroy(face); }
};
using Pattern = std::unique_ptr<FcPattern, Release>;

struct Character {
  FcChar32 code;
  std::string bytes;
};

// The characters of a text; U+FFFD for what cairo would refuse or draw as a box.
std::vector<Character> Characters(const std::string& text) {
  std::vector<Character> characters;
  for (size_t at = 0; at < text.size();) {
    FcChar32 code = 0;
    const int length = FcUtf8ToUcs4(reinterpret_cast<const FcChar8*>(text.data() + at), &code,
                                    static_cast<int>(std::min<size_t>(8, text.size() - at)));
    const bool surrogate = code >= 0xd800 && code < 0xe000;
    const bool control = code < 0x20 || (code >= 0x7f && code < 0xa0);
    if (length < 1 || control || surrogate || code > 0x10ffff) {
      characters.push_back({0xfffd, kReplacement});
    } else {
      characters.push_back({code, text.substr(at, static_cast<size_t>(length))});
    }
    at += static_cast<size_t>(std::max(1, length));
  }
  return characters;
}

std::string Clean(const std::string& text) {
  std::string clean;
  for (const Character& character : Characters(text)) clean += character.bytes;
  return clean;
}

// The installed font for a text; nullptr if there is none at all.
Pattern MatchFont(const std::string& text) {
  const Pattern wanted(FcPatternCreate());
  const std::unique_ptr<FcCharSet, Release> characters(FcCharSetCreate());
  for (const Character& character : Characters(text)) FcCharSetAddChar(characters.get(), character.code);
  FcPatternAddCharSet(wanted.get(), FC_CHARSET, characters.get());
  for (const char* family : {"DejaVu Sans", "sans-serif"}) {
    FcPatternAddString(wanted.get(), FC_FAMILY, reinterpret_cast<const FcChar8*>(family));
  }
  FcPatternAddBool(wanted.get(), FC_SCALABLE, FcTrue);
  FcConfigSubstitute(nullptr, wanted.get(), FcMatchPattern);
  FcDefaultSubstitute(wanted.get());
  FcResult result;
  Pattern found(FcFontMatch(nullptr, wanted.get(), &result));
  FcChar8* file = nullptr;
  const bool is_font = found && FcPatternGetString(found.get(), FC_FILE, 0, &file) == FcResultMatch;
  return is_font ? std::move(found) : nullptr;
}

// The beginning of `line` that has room for an ellipsis after it.
std::string WithEllipsis(const std::string& line, double width, cairo_t* cairo) {
  std::vector<Character> characters = Characters(line);
  std::string shortened = line + kEllipsis;
  while (!characters.empty() && TextWidth(shortened, cairo) > width) {
    characters.pop_back();
    shortened.clear();
    for (const Character& character : characters) shortened += character.bytes;
    shortened += kEllipsis;
  }
  return shortened;
}

}  // namespace

absl::Status CheckFonts() {
  if (MatchFont("0") != nullptr) return absl::OkStatus();
  return absl::FailedPreconditionError(
      "no font is installed, which the scale bar of a picture needs: install one, for example the package "
      "fonts-dejavu-core");
}

std::string LetteringProblem(const std::string& text) {
  const Pattern font = MatchFont(text);
  FcCharSet* has = nullptr;
  const bool is_known = FcPatternGetCharSet(font.get(), FC_CHARSET, 0, &has) == FcResultMatch;
  std::string missing;
  bool is_shaped = false;
  for (const Character& character : Characters(text)) {
    if (is_known && FcCharSetHasChar(has, character.code) == FcFalse) missing += character.bytes;
    is_shaped |= std::any_of(std::begin(kShapedScripts), std::end(kShapedScripts), [&](const CodeRange& range) {
      return character.code >= range.first && character.code <= range.last;
    });
  }
  if (!missing.empty()) {
    return absl::StrCat("no installed font has all of \"", text, "\": ", missing, " will be boxes. Install a font of ",
                        "that language, for example one of the packages fonts-noto");
  }
  if (!is_shaped) return "";
  return absl::StrCat("\"", text, "\" has letters that are joined, stacked or written from right to left, which curv ",
                      "does not do: they stand one by one, from the left");
}

void SelectFont(const std::string& text, double size, cairo_t* cairo) {
  const Pattern pattern = MatchFont(text);
  const std::unique_ptr<cairo_font_face_t, Release> face(cairo_ft_font_face_create_for_pattern(pattern.get()));
  const std::unique_ptr<cairo_font_options_t, Release> options(cairo_font_options_create());
  cairo_font_options_set_antialias(options.get(), CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(cairo, options.get());
  cairo_set_font_face(cairo, face.get());
  cairo_set_font_size(cairo, size);
}

double TextWidth(const std::string& text, cairo_t* cairo) {
  cairo_text_extents_t extents;
  cairo_text_extents(cairo, Clean(text).c_str(), &extents);
  return extents.x_advance;
}

void DrawText(const std::string& text, double x, double y, cairo_t* cairo) {
  cairo_move_to(cairo, x, y);
  cairo_show_text(cairo, Clean(text).c_str());
}

std::vector<std::string> BreakLines(const std::string& text, double width, size_t max_lines, cairo_t* cairo) {
  std::vector<std::string> lines;
  std::string line;
  for (const Character& character : Characters(text)) {
    line += character.bytes;
    if (TextWidth(line, cairo) <= width || line == character.bytes) continue;
    // The line is broken after its last blank, or before this character.
    const size_t blank = line.rfind(' ', line.size() - 2);
    const size_t end = character.code == ' '        ? line.size() - 1
                       : blank == std::string::npos ? line.size() - character.bytes.size()
                                                    : blank;
    lines.push_back(line.substr(0, end));
    line.erase(0, end);
    if (line.front() == ' ') line.erase(0, 1);
  }
  if (!line.empty()) lines.push_back(line);
  if (lines.size() > max_lines) {
    lines.resize(max_lines);
    lines.back() = WithEllipsis(lines.back(), width, cairo);
  }
  return lines;
}

}  // namespace curv
