#include "client/render/canvas.h"

#include <cstddef>
#include <cstdint>
#include <new>

namespace curv {
namespace {

// A pixel of CAIRO_FORMAT_RGB24.
uint32_t Pack(const Color& color) {
  return uint32_t{ToByte(color.red)} << 16 | uint32_t{ToByte(color.green)} << 8 | ToByte(color.blue);
}

Color Unpack(uint32_t pixel) {
  const auto channel = [pixel](int shift) { return static_cast<float>(pixel >> shift & 0xff) / 255.0f; };
  return {channel(16), channel(8), channel(0)};
}

// Calls visit(pixel of the surface, pixel of the picture) for each pixel that both have.
template <typename Visitor>
void ForEachPixel(cairo_surface_t* surface, int left, Image& image, const Visitor& visit) {
  const auto stride = static_cast<size_t>(cairo_image_surface_get_stride(surface));
  unsigned char* const bytes = cairo_image_surface_get_data(surface);
  for (int y = 0; y < image.height; ++y) {
    auto* const row = reinterpret_cast<uint32_t*>(bytes + static_cast<size_t>(y) * stride);
    for (int x = left; x < image.width; ++x) visit(row[x - left], image.at(x, y));
  }
}

}  // namespace

Canvas::Canvas(int left, Image& image)
    : left_(left),
      image_(image),
      surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width - left, image.height)),
      cairo_(cairo_create(surface_.get())) {
  // Fails only for lack of memory.
  if (cairo_status(cairo_.get()) != CAIRO_STATUS_SUCCESS) throw std::bad_alloc();
  ForEachPixel(surface_.get(), left_, image_, [](uint32_t& pixel, const Color& color) { pixel = Pack(color); });
  cairo_surface_mark_dirty(surface_.get());
}

Canvas::~Canvas() {
  cairo_surface_flush(surface_.get());
  ForEachPixel(surface_.get(), left_, image_, [](uint32_t pixel, Color& color) { color = Unpack(pixel); });
}

void SetColor(const Color& color, cairo_t* cairo) {
  cairo_set_source_rgb(cairo, double{color.red}, double{color.green}, double{color.blue});
}

}  // namespace curv
