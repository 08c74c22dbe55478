// Writes text into pictures, in any language that an installed font has the characters of.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"

// Cairo's own name for what cairo_t is, so that who writes no text need not know cairo.
typedef struct _cairo cairo_t;

namespace curv {

// OK if a font is installed; FAILED_PRECONDITION saying how to get one if not.
absl::Status CheckFonts();

// Returns "", or in a sentence what of `text` will not look as it should: characters that no installed font has, which
// become boxes, and scripts whose letters are joined, stacked or written from right to left, which cairo alone does not
// do. REQUIRES: CheckFonts() is OK.
std::string LetteringProblem(const std::string& text);

// Makes the sans-serif font that has most of the characters of `text` the one that is written with, `size` pixels high
// from line to line. Outlines are not fitted to the pixels, so that widths do not depend on the size.
// REQUIRES: CheckFonts() is OK.
void SelectFont(const std::string& text, double size, cairo_t* cairo);

// Width in pixels of `text` in the font that is selected.
double TextWidth(const std::string& text, cairo_t* cairo);

// Writes `text` from `x` to the right, its baseline at `y` (pixels, y downward). Bytes that are not UTF-8 and control
// characters become U+FFFD.
void DrawText(const std::string& text, double x, double y, cairo_t* cairo);

// Breaks `text` into lines of at most `width` pixels in the font that is selected: at blanks, or within a word that has
// no room in a line. No more than `max_lines`; the last one ends with an ellipsis if there is more.
// REQUIRES: max_lines >= 1.
std::vector<std::string> BreakLines(const std::string& text, double width, size_t max_lines, cairo_t* cairo);

}  // namespace curv
