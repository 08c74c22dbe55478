#include "bench/paper/sides/patch_samples.h"

#include <cmath>
#include <random>
#include <vector>

#include "client/surfaces/vec3.h"

namespace curvd::bench {
namespace {

using curv::Vec3;

// Cubes of edge 1 with the points in them, by a hash that may mix cubes up.
class Neighbors {
 public:
  explicit Neighbors(size_t points) : cubes_(2 * points + 1) {}
  // Whether a point of the same side of the surface is nearer than `distance`, which is at most 1.
  bool IsNear(const Samples& samples, const Vec3& p, const Vec3& n, double distance) const {
    for (double x = -1; x <= 1; ++x) {
      for (double y = -1; y <= 1; ++y) {
        for (double z = -1; z <= 1; ++z) {
          for (const size_t i : cubes_[CubeOf(p + Vec3{x, y, z})]) {
            const Vec3 offset = p - samples.positions[i];
            if (curv::Dot(offset, offset) < distance * distance && curv::Dot(n, samples.normals[i]) > 0.0) return true;
          }
        }
      }
    }
    return false;
  }
  void Add(size_t i, const Vec3& p) { cubes_[CubeOf(p)].push_back(i); }

 private:
  size_t CubeOf(const Vec3& p) const {
    uint64_t hash = 0;
    for (const double c : {p.x, p.y, p.z}) {
      hash = (hash ^ static_cast<uint64_t>(static_cast<int64_t>(std::floor(c)))) * 0x9E3779B97F4A7C15u;
    }
    return static_cast<size_t>((hash >> 20) % cubes_.size());
  }
  std::vector<std::vector<size_t>> cubes_;
};

}  // namespace

Shape SampleOf(const Patch& patch, size_t points, uint64_t seed, bool is_apart) {
  constexpr double kApart = 0.7;
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const auto try_one = [&](Vec3& p, Vec3& n) {
    const double chance = uniform() * patch.most_area;
    const double u = uniform(), v = uniform();
    return chance <= patch.at(u, v, p, n);
  };
  double area = patch.area;
  if (is_apart && area == 0.0) {
    constexpr int kTrials = 200'000;
    Vec3 p, n;
    for (int i = 0; i < kTrials; ++i) area += try_one(p, n) ? patch.most_area / kTrials : 0.0;
  }
  const double known_scale = std::sqrt(static_cast<double>(points) / area);
  Shape shape{patch.name + (is_apart ? ", apart" : ""), {}, patch.is_open};
  Neighbors neighbors(points);
  double trials = 0.0;
  while (shape.samples.positions.size() < points) {
    Vec3 p, n;
    ++trials;
    if (!try_one(p, n)) continue;
    if (is_apart) {
      p = known_scale * p;
      if (neighbors.IsNear(shape.samples, p, n, kApart)) continue;
      neighbors.Add(shape.samples.positions.size(), p);
    }
    shape.samples.positions.push_back(p);
    shape.samples.normals.push_back(n);
  }
  if (is_apart) return shape;
  if (area == 0.0) area = patch.most_area * static_cast<double>(points) / trials;
  const double scale = std::sqrt(static_cast<double>(points) / area);
  for (Vec3& p : shape.samples.positions) p = scale * p;
  return shape;
}

}  // namespace curvd::bench
