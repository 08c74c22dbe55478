// Writes text into pictures, in any language that installed fonts have the characters of: letters are joined and
// stacked as their script asks for, and stand in the order in which they are read.
#pragma once

#include <memory>
#include <string>

#include "absl/status/status.h"

// The libraries' own names for what cairo_t and PangoLayout are, so that who writes no text need not know them.
typedef struct _cairo cairo_t;
typedef struct _PangoLayout PangoLayout;

namespace curv {

// OK if a font is installed; FAILED_PRECONDITION saying how to get one if not.
absl::Status CheckFonts();

// Returns "", or in a sentence which characters of `text` no installed font has, which become boxes.
// REQUIRES: CheckFonts() is OK.
std::string LetteringProblem(const std::string& text);

// A text, laid out in lines. Sans-serif; characters that this font lacks come from others. Bytes that are not UTF-8 and
// control characters become U+FFFD. Not thread-safe.
class TextBlock {
 public:
  // One line, letters of `size` pixels from line to line, in the units of `cairo`, which must outlive the block.
  // Outlines are not fitted to the pixels, so that widths do not depend on the size. REQUIRES: CheckFonts() is OK.
  TextBlock(const std::string& text, double size, cairo_t* cairo);

  // Lines of at most `width`, broken where the language breaks them, or within a word that has no room in a line. No
  // more than `max_lines`; the last one ends with an ellipsis if there is more. REQUIRES: max_lines >= 1, width > 0.
  TextBlock(const std::string& text, double size, double width, int max_lines, cairo_t* cairo);

  // Of the widest line.
  double width() const;

  int line_count() const;

  // Writes the lines, `spacing` apart, between `x` and x + width(): the first one's baseline at `y`, y downward. They
  // begin at `x`, or end at x + width() if the text is read from the right.
  void Draw(double x, double y, double spacing) const;

  // Writes a block of one line.
  void Draw(double x, double y) const { Draw(x, y, 0.0); }

 private:
  struct Release {
    void operator()(PangoLayout* layout) const;
  };

  cairo_t* cairo_;
  std::unique_ptr<PangoLayout, Release> layout_;
};

}  // namespace curv
