#include "tests/core/umbrella_clouds.h"

#include <cmath>

#include "core/estimators/triangles/random_stream.h"

namespace curvd::testing {
namespace {

// Uniform in [-1, 1).
double Signed(RandomStream& random) { return static_cast<double>(random.Next() >> 11) * 0x1p-52 - 1.0; }

// A saddle over a square, whose border leaves umbrellas with gaps.
TestPoints Patch(size_t points, uint64_t seed) {
  TestPoints patch;
  for (size_t i = 0; i < points; ++i) {
    RandomStream random(seed, i);
    const double x = Signed(random), y = Signed(random);
    const double zx = 0.8 * x, zy = -0.5 * y, length = std::sqrt(zx * zx + zy * zy + 1.0);
    patch.Add(x, y, 0.4 * x * x - 0.25 * y * y, -zx / length, -zy / length, 1.0 / length);
  }
  return patch;
}

// Points a * (1, 2, 2) + b * (2, 1, -2) in shuffled order: exact, but in no frame along the axes. `copies` at each.
TestPoints TiltedLattice(int side, int copies, uint64_t seed) {
  std::vector<std::array<int, 2>> places;
  for (int a = 0; a < side; ++a) {
    for (int b = 0; b < side; ++b) places.insert(places.end(), copies, {a, b});
  }
  RandomStream random(seed, 0);
  for (size_t i = places.size(); i > 1; --i) std::swap(places[i - 1], places[random.Next() % i]);
  TestPoints lattice;
  for (const auto& [a, b] : places) lattice.Add(a + 2 * b, 2 * a + b, 2 * a - 2 * b, -2.0 / 3, 2.0 / 3, -1.0 / 3);
  return lattice;
}

// The 36 integer points at distance 65 around a center, each of a few such circles far from the others. A center has
// more triangles than an umbrella holds; all others lie on one circle.
TestPoints Circles(uint64_t seed) {
  constexpr int kQuarter[9][2] = {{65, 0},  {63, 16}, {60, 25}, {56, 33}, {52, 39},
                                  {39, 52}, {33, 56}, {25, 60}, {16, 63}};
  TestPoints circles;
  RandomStream random(seed, 1);
  for (int c = 0; c < 8; ++c) {
    // The center comes first, amid, or last, so that it has the lowest id or not.
    const auto center = static_cast<int>(random.Next() % 37);
    for (int i = 0, on = 0; i < 37; ++i) {
      if (i == center) {
        circles.Add(1000 * c, 0, 0, 0, 0, 1);
        continue;
      }
      const int quarter = on * 7 % 36 / 9, at = on * 7 % 36 % 9;
      ++on;
      const int x = kQuarter[at][0], y = kQuarter[at][1];
      const int turned[4][2] = {{x, y}, {-y, x}, {-x, -y}, {y, -x}};
      circles.Add(1000 * c + turned[quarter][0], turned[quarter][1], 0, 0, 0, 1);
    }
  }
  return circles;
}

}  // namespace

std::vector<NamedPoints> UmbrellaClouds(uint64_t seed) {
  std::vector<NamedPoints> clouds = {{"patch", Patch(600, seed)},
                                     {"tilted lattice", TiltedLattice(20, 1, seed)},
                                     {"tilted lattice of doubles", TiltedLattice(14, 2, seed)},
                                     {"circles", Circles(seed)},
                                     {"three points", Patch(3, seed)},
                                     {"sphere", Sphere(500 + seed, 2.0)}};
  for (Layout layout : kLayouts) clouds.push_back({LayoutName(layout), RandomPoints(layout, 300, seed)});
  return clouds;
}

}  // namespace curvd::testing
