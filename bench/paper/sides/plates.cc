#include "bench/paper/sides/plates.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "absl/strings/str_format.h"
#include "client/surfaces/vec3.h"

namespace curvd::bench {
namespace {

using curv::Vec3;
using Polygon = std::vector<std::array<double, 2>>;

double AreaOf(const Polygon& p) {
  double twice = 0.0;
  for (size_t i = 0; i < p.size(); ++i) {
    const auto &a = p[i], &b = p[(i + 1) % p.size()];
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return 0.5 * twice;
}

double OutlineOf(const Polygon& p) {
  double sum = 0.0;
  for (size_t i = 0; i < p.size(); ++i) {
    const auto &a = p[i], &b = p[(i + 1) % p.size()];
    sum += std::hypot(b[0] - a[0], b[1] - a[1]);
  }
  return sum;
}

bool IsInside(const Polygon& p, double x, double y) {
  bool inside = false;
  for (size_t i = 0; i < p.size(); ++i) {
    const auto &a = p[i], &b = p[(i + 1) % p.size()];
    if ((a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1])) inside = !inside;
  }
  return inside;
}

// Counterclockwise, about the origin, of a size near 1.
Polygon Outline(const std::string& name) {
  if (name == "square") return {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  if (name == "strip") return {{-4, -0.5}, {4, -0.5}, {4, 0.5}, {-4, 0.5}};
  if (name == "bracket") return {{-1, -1}, {1, -1}, {1, -0.2}, {-0.2, -0.2}, {-0.2, 1}, {-1, 1}};
  if (name == "triangle") return {{-1, -0.6}, {1, -0.6}, {0, 1.1}};
  Polygon round;
  const bool is_star = name == "star";
  const int corners = is_star ? 10 : 96;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / corners, radius = is_star && i % 2 == 1 ? 0.5 : 1.0;
    round.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return round;
}

constexpr std::array kSamplings = {"shaken", "random", "lattice"};

}  // namespace

Shape Plate(const std::string& outline, size_t points, double thickness, Sampling sampling, uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  Polygon polygon = Outline(outline);
  // Twice the area and the narrow sides make as many points of spacing 1.
  const double area = 2.0 * AreaOf(polygon), side = OutlineOf(polygon) * thickness;
  const double scale = (-side + std::sqrt(side * side + 4.0 * area * static_cast<double>(points))) / (2.0 * area);
  double reach = 0.0;
  for (auto& corner : polygon) {
    for (double& c : corner) c *= scale, reach = std::max(reach, std::abs(c));
  }
  Shape shape;
  shape.name =
      absl::StrFormat("plate %s %s, %.1f thick", outline, kSamplings[static_cast<size_t>(sampling)], thickness);
  const auto add = [&](const Vec3& p, const Vec3& n) {
    shape.samples.positions.push_back(p);
    shape.samples.normals.push_back(n);
  };
  const double shake = sampling == Sampling::kShaken ? 0.7 : 0.0;
  for (const double up : {-1.0, 1.0}) {
    const auto take = [&](double x, double y) {
      if (IsInside(polygon, x, y)) add({x, y, 0.5 * up * thickness}, {0, 0, up});
    };
    if (sampling == Sampling::kRandom) {
      const double trials = 4.0 * reach * reach;
      for (double i = 0; i < trials; ++i) take((2 * uniform() - 1) * reach, (2 * uniform() - 1) * reach);
    } else {
      for (double x = -std::floor(reach) - 0.5; x <= reach; ++x) {
        for (double y = -std::floor(reach) - 0.5; y <= reach; ++y) {
          take(x + shake * (uniform() - 0.5), y + shake * (uniform() - 0.5));
        }
      }
    }
  }
  for (size_t i = 0; i < polygon.size(); ++i) {
    const auto &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double dx = b[0] - a[0], dy = b[1] - a[1], length = std::hypot(dx, dy);
    const Vec3 normal{dy / length, -dx / length, 0};
    const auto at = [&](double t, double z) { add({a[0] + t * dx, a[1] + t * dy, z}, normal); };
    if (sampling == Sampling::kRandom) {
      double left = length * thickness + uniform() - 0.5;
      for (; left > 0.5; --left) at(uniform(), (uniform() - 0.5) * thickness);
      continue;
    }
    const double rows = std::max(1.0, std::round(thickness)),
                 columns = std::max(1.0, std::round(length * thickness / rows));
    for (double row = 0.5; row < rows; ++row) {
      for (double column = 0.5; column < columns; ++column) {
        at((column + shake * (uniform() - 0.5)) / columns,
           ((row + shake * (uniform() - 0.5)) / rows - 0.5) * thickness);
      }
    }
  }
  return shape;
}

}  // namespace curvd::bench
