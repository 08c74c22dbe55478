#include "client/render/image.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <new>

namespace curv {

uint8_t ToByte(float channel) { return static_cast<uint8_t>(std::lround(255.0f * std::clamp(channel, 0.0f, 1.0f))); }

std::string EncodePng(const Image& image) {
  std::vector<uint8_t> bytes;
  bytes.reserve(3 * image.pixels.size());
  for (const Color& color : image.pixels) {
    bytes.insert(bytes.end(), {ToByte(color.red), ToByte(color.green), ToByte(color.blue)});
  }
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string png(size, '\0');
  // Fails only for lack of memory or of room, and the room is the largest that a PNG of this size takes.
  if (png_image_write_to_memory(&header, png.data(), &size, /*convert_to_8_bit=*/0, bytes.data(), 0, nullptr) == 0) {
    throw std::bad_alloc();
  }
  png.resize(size);
  return png;
}

}  // namespace curv
