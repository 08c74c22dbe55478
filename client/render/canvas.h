// Lets cairo draw on a picture.
#pragma once

#include <cairo.h>

#include <memory>

#include "client/render/image.h"

namespace curv {

// The columns of a picture from `left` on, as a surface of cairo whose upper left corner is their own. What was drawn
// is in the picture once the canvas is gone. Not thread-safe.
class Canvas {
 public:
  // REQUIRES: 0 <= left < image.width; the image outlives the canvas.
  Canvas(int left, Image& image);
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;
  ~Canvas();

  cairo_t* cairo() { return cairo_.get(); }

 private:
  struct Release {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* cairo) const { cairo_destroy(cairo); }
  };

  int left_;
  Image& image_;
  std::unique_ptr<cairo_surface_t, Release> surface_;
  std::unique_ptr<cairo_t, Release> cairo_;
};

// Makes a color the one that is drawn with.
void SetColor(const Color& color, cairo_t* cairo);

}  // namespace curv
