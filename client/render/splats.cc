#include "client/render/splats.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace curv {
namespace {

// What is known of one sample of the picture.
struct Sample {
  float depth = -std::numeric_limits<float>::infinity();  // of the nearest disc
  float weight = 0.0f;
  Color color;
  float normal[3] = {0.0f, 0.0f, 0.0f};
};

// Light that a surface with this normal, in the coordinates of the picture, sends to the viewer.
Color Shade(const Color& color, Vec3 normal) {
  constexpr Vec3 kLight{-0.28, 0.40, 0.8727};  // unit
  // Light wraps around the surface, so that no side is too dark for its color to be read.
  constexpr double kAmbient = 0.50, kDiffuse = 0.54, kWrap = 0.35, kSpecular = 0.08, kShininess = 24.0;
  if (normal.z < 0.0) normal = -normal;
  const double diffuse = std::max(0.0, (Dot(normal, kLight) + kWrap) / (1.0 + kWrap));
  const Vec3 halfway = Normalized(kLight + Vec3{0, 0, 1});
  const double specular = kSpecular * std::pow(std::max(0.0, Dot(normal, halfway)), kShininess);
  const float lit = static_cast<float>(kAmbient + kDiffuse * diffuse);
  const float shine = static_cast<float>(specular);
  return lit * color + Color{shine, shine, shine};
}

// A grid of samples, oversampling to the pixel.
class SampleGrid {
 public:
  SampleGrid(int width, int height) : width_(width), height_(height) {
    samples_.resize(static_cast<size_t>(width) * static_cast<size_t>(height));
  }

  // First pass: the depth of what is in front.
  void AddDepth(const Splat& splat) {
    ForEachCovered(splat, [](Sample& sample, float depth, float) { sample.depth = std::max(sample.depth, depth); });
  }

  // Second pass, once all depths are there: blends what is near the front.
  void AddColor(const Splat& splat) {
    // Layers of a surface are farther apart than its points are.
    const float reach = static_cast<float>(splat.radius);
    ForEachCovered(splat, [&](Sample& sample, float depth, float closeness) {
      if (depth < sample.depth - reach) return;
      const float weight = closeness * closeness;
      sample.weight += weight;
      sample.color = sample.color + weight * splat.color;
      for (int axis = 0; axis < 3; ++axis) sample.normal[axis] += weight * static_cast<float>(splat.normal[axis]);
    });
  }

  float Depth(int x, int y) const { return at(x, y).depth; }

  // The lit color of a sample; false if nothing covers it.
  bool Resolve(int x, int y, Color& color) const {
    const Sample& sample = at(x, y);
    if (!(sample.weight > 0.0f)) return false;
    const Vec3 sum{sample.normal[0], sample.normal[1], sample.normal[2]};
    const double length = Norm(sum);
    // Normals of opposite directions can cancel out: such a place faces the viewer as well as not.
    const Vec3 normal = length > 0.0 ? (1.0 / length) * sum : Vec3{0, 0, 1};
    color = Shade((1.0f / sample.weight) * sample.color, normal);
    return true;
  }

 private:
  Sample& at(int x, int y) {
    return samples_[static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)];
  }
  const Sample& at(int x, int y) const { return const_cast<SampleGrid*>(this)->at(x, y); }

  // Calls visit(sample, depth, closeness) for each sample on the disc; closeness falls from 1 at its center to 0.
  template <typename Visitor>
  void ForEachCovered(const Splat& splat, const Visitor& visit) {
    // A disc seen from its edge is as thin as a line; it is widened to what a sample can catch.
    constexpr double kMinFacing = 0.15;
    const double facing = std::copysign(std::max(std::abs(splat.normal.z), kMinFacing), splat.normal.z);
    const double slope_x = -splat.normal.x / facing, slope_y = splat.normal.y / facing;
    const double radius = std::max(splat.radius, 0.75);
    const int left = std::max(0, static_cast<int>(std::ceil(splat.center.x - radius - 0.5)));
    const int right = std::min(width_ - 1, static_cast<int>(std::floor(splat.center.x + radius - 0.5)));
    const int top = std::max(0, static_cast<int>(std::ceil(splat.center.y - radius - 0.5)));
    const int bottom = std::min(height_ - 1, static_cast<int>(std::floor(splat.center.y + radius - 0.5)));
    for (int y = top; y <= bottom; ++y) {
      const double dy = y + 0.5 - splat.center.y;
      for (int x = left; x <= right; ++x) {
        const double dx = x + 0.5 - splat.center.x;
        const double dz = slope_x * dx + slope_y * dy;
        const double squared = (dx * dx + dy * dy + dz * dz) / (radius * radius);
        if (squared < 1.0) visit(at(x, y), static_cast<float>(splat.center.z + dz), static_cast<float>(1.0 - squared));
      }
    }
  }

  int width_;
  int height_;
  std::vector<Sample> samples_;
};

// Averages the samples of each pixel, over what was there before.
void Downsample(const SampleGrid& grid, int oversampling, Image& image) {
  const float share = 1.0f / static_cast<float>(oversampling * oversampling);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Color background = image.at(x, y);
      Color sum;
      for (int sample = 0; sample < oversampling * oversampling; ++sample) {
        Color color = background;
        grid.Resolve(x * oversampling + sample % oversampling, y * oversampling + sample / oversampling, color);
        sum = sum + Color{std::min(color.red, 1.0f), std::min(color.green, 1.0f), std::min(color.blue, 1.0f)};
      }
      image.at(x, y) = share * sum;
    }
  }
}

}  // namespace

std::vector<float> DrawSplats(const std::vector<Splat>& splats, int oversampling, Image& image) {
  SampleGrid grid(image.width * oversampling, image.height * oversampling);
  const auto enlarged = [oversampling](Splat splat) {
    splat.center = static_cast<double>(oversampling) * splat.center;
    splat.radius *= oversampling;
    return splat;
  };
  for (const Splat& splat : splats) grid.AddDepth(enlarged(splat));
  for (const Splat& splat : splats) grid.AddColor(enlarged(splat));
  Downsample(grid, oversampling, image);
  std::vector<float> depths;
  depths.reserve(image.pixels.size());
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      depths.push_back(grid.Depth(x * oversampling, y * oversampling) / static_cast<float>(oversampling));
    }
  }
  return depths;
}

}  // namespace curv
