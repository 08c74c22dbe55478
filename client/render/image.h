// Holds a picture in memory, and makes a PNG file of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace curv {

// A color of the screen (sRGB), with channels from 0 to 1.
struct Color {
  float red = 0.0f;
  float green = 0.0f;
  float blue = 0.0f;

  friend Color operator+(const Color& a, const Color& b) { return {a.red + b.red, a.green + b.green, a.blue + b.blue}; }
  friend Color operator*(float s, const Color& a) { return {s * a.red, s * a.green, s * a.blue}; }
};

// Pixels by rows from the top, in each row from the left.
struct Image {
  Image(int width, int height, const Color& background)
      : width(width), height(height), pixels(static_cast<size_t>(width) * static_cast<size_t>(height), background) {}

  // REQUIRES: 0 <= x < width, 0 <= y < height.
  Color& at(int x, int y) {
    return pixels[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
  const Color& at(int x, int y) const { return const_cast<Image*>(this)->at(x, y); }

  int width;
  int height;
  std::vector<Color> pixels;
};

// Returns the nearest of the 256 levels of a channel.
uint8_t ToByte(float channel);

// Returns the bytes of a PNG file.
std::string EncodePng(const Image& image);

}  // namespace curv
