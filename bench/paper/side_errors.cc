// Sides of normals that are made of positions alone: how many are wrong, and whether the certificate tells.
//
// Each row is one cloud of points whose spacing is 1 on average. An open cloud may have either side, but one only.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "bench/paper/samples.h"
#include "client/surfaces/noise.h"
#include "client/surfaces/vec3.h"
#include "core/job/normals_job.h"

namespace curvd::bench {
namespace {

using curv::Vec3;
using Polygon = std::vector<std::array<double, 2>>;

struct Shape {
  std::string name;
  Samples samples;
  bool is_open = false;
};

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

enum class Sampling { kShaken, kRandom, kLattice };
constexpr std::array kSamplings = {"shaken", "random", "lattice"};

// A plate of the outline, its narrow sides included, tilted.
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

// Turns all about an axis that is no one's.
void Tilt(double angle, Samples& samples) {
  const Vec3 axis = (1.0 / std::sqrt(1.0 + 4.0 + 9.0)) * Vec3{1, 2, 3};
  const double c = std::cos(angle), s = std::sin(angle);
  for (auto* vectors : {&samples.positions, &samples.normals}) {
    for (Vec3& v : *vectors) v = c * v + s * curv::Cross(axis, v) + ((1.0 - c) * curv::Dot(axis, v)) * axis;
  }
}

// A map of the unit square to a surface, with the normal, and the area that it makes of an area there.
struct Patch {
  std::string name;
  bool is_open;
  double most_area;  // of the map, per unit square
  double area;       // of the surface
  std::function<double(double u, double v, Vec3& position, Vec3& normal)> at;
};

constexpr double kPi = std::numbers::pi;

Patch TorusPatch(double ring, double tube) {
  const double area = 4.0 * kPi * kPi * ring * tube;
  return {absl::StrFormat("torus %g/%g", ring, tube), false, 4.0 * kPi * kPi * (ring + tube) * tube, area,
          [=](double u, double v, Vec3& p, Vec3& n) {
            const double a = 2 * kPi * u, b = 2 * kPi * v, radius = ring + tube * std::cos(b);
            n = {std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b)};
            p = {radius * std::cos(a), radius * std::sin(a), tube * std::sin(b)};
            return 4.0 * kPi * kPi * radius * tube;
          }};
}

Patch EllipsoidPatch(double a, double b, double c) {
  Patch patch{absl::StrFormat("ellipsoid %g/%g/%g", a, b, c), false, 4.0 * kPi * std::max({a * b, b * c, a * c}), 0.0,
              [=](double u, double v, Vec3& p, Vec3& n) {
                const double z = 2 * v - 1, r = std::sqrt(std::max(1 - z * z, 0.0)), t = 2 * kPi * u;
                const double x = r * std::cos(t), y = r * std::sin(t);
                p = {a * x, b * y, c * z};
                const Vec3 m{x / a, y / b, z / c};
                const double length = std::sqrt(curv::Dot(m, m));
                n = (1.0 / length) * m;
                return 4.0 * kPi * a * b * c * length;
              }};
  return patch;
}

Patch HeightPatch(const std::string& name, std::function<double(double, double)> height) {
  return {name, true, 16.0, 0.0, [height = std::move(height)](double u, double v, Vec3& p, Vec3& n) {
            const double x = 2 * u - 1, y = 2 * v - 1, h = 1e-5;
            const double a = (height(x + h, y) - height(x - h, y)) / (2 * h),
                         b = (height(x, y + h) - height(x, y - h)) / (2 * h);
            const double length = std::sqrt(1 + a * a + b * b);
            p = {x, y, height(x, y)};
            n = (1.0 / length) * Vec3{-a, -b, 1};
            return 4.0 * length;
          }};
}

Patch CylinderPatch(double radius, double half) {  // without caps
  return {absl::StrFormat("open cylinder %g/%g", radius, half), true, 4 * kPi * radius * half, 0.0,
          [=](double u, double v, Vec3& p, Vec3& n) {
            const double t = 2 * kPi * u;
            n = {std::cos(t), std::sin(t), 0};
            p = {radius * n.x, radius * n.y, (2 * v - 1) * half};
            return 4 * kPi * radius * half;
          }};
}

Patch BowlPatch(double share) {  // the lower part of a ball
  return {absl::StrFormat("bowl %g", share), true, 4 * kPi * share, 0.0, [=](double u, double v, Vec3& p, Vec3& n) {
            const double z = 2 * share * v - 1, r = std::sqrt(std::max(1 - z * z, 0.0)), t = 2 * kPi * u;
            p = n = {r * std::cos(t), r * std::sin(t), z};
            return 4 * kPi * share;
          }};
}

// The radii at which `points` points of spacing 1 on two spheres are `thickness` apart.
std::array<double, 2> RadiiOfWall(size_t points, double thickness, double share) {
  // share * 4 pi (r^2 + (r - t)^2) = points
  const double squares = static_cast<double>(points) / (4.0 * kPi * share);
  const double outer = 0.5 * (thickness + std::sqrt(2.0 * squares - thickness * thickness));
  return {outer, outer - thickness};
}

// A sphere that is flattened to this thickness in its middle, in units of the spacing.
Patch LensPatch(size_t points, double thickness) {
  const double radius = std::sqrt(static_cast<double>(points) / (2.0 * kPi));
  Patch patch = EllipsoidPatch(1, 1, 0.5 * thickness / radius);
  patch.name = absl::StrFormat("lens, %g thick", thickness);
  return patch;
}

// A hollow ball: the space between two spheres.
Patch HollowPatch(size_t points, double thickness) {
  const auto [outer, inner] = RadiiOfWall(points, thickness, 1.0);
  const double out = outer * outer, in = inner * inner, most = 4.0 * kPi * (out + in);
  return {absl::StrFormat("hollow ball, %g thick", thickness), false, most, most,
          [=](double u, double v, Vec3& p, Vec3& n) {
            const bool is_outer = u * (out + in) < out;
            const double t = 2 * kPi * (is_outer ? u * (out + in) / out : (u * (out + in) - out) / in);
            const double z = 2 * v - 1, r = std::sqrt(std::max(1 - z * z, 0.0));
            n = {r * std::cos(t), r * std::sin(t), z};
            p = (is_outer ? outer : inner) * n;
            if (!is_outer) n = -1.0 * n;
            return most;
          }};
}

// A bowl with a wall: the lower `share` of a hollow ball, closed by a rim.
Patch PotPatch(size_t points, double thickness, double share) {
  const auto [outer, inner] = RadiiOfWall(points, thickness, share);
  const double top = 2 * share - 1, across = std::sqrt(std::max(1 - top * top, 0.0));
  const double out = 4 * kPi * share * outer * outer, in = 4 * kPi * share * inner * inner;
  const double rim = kPi * across * (outer * outer - inner * inner), most = out + in + rim;
  return {absl::StrFormat("pot %g, %g thick", share, thickness), false, most, most,
          [=](double u, double v, Vec3& p, Vec3& n) {
            const double area = u * most, t = 2 * kPi * v;
            if (area >= out + in) {  // the normal of a cone
              const double part = (area - out - in) / rim;
              const double radius = std::sqrt(inner * inner + part * (outer * outer - inner * inner));
              p = radius * Vec3{across * std::cos(t), across * std::sin(t), top};
              n = {-top * std::cos(t), -top * std::sin(t), across};
              return most;
            }
            const bool is_outer = area < out;
            const double part = is_outer ? area / out : (area - out) / in;
            const double z = 2 * share * part - 1, r = std::sqrt(std::max(1 - z * z, 0.0));
            n = {r * std::cos(t), r * std::sin(t), z};
            p = (is_outer ? outer : inner) * n;
            if (!is_outer) n = -1.0 * n;
            return most;
          }};
}

// A body whose surface is made of parts; each has an area, and maps the unit square to itself evenly.
struct Part {
  double area;
  std::function<void(double u, double v, Vec3& position, Vec3& normal)> at;
};

Patch BodyOf(const std::string& name, std::vector<Part> parts) {
  double area = 0.0;
  for (const Part& part : parts) area += part.area;
  return {name, false, area, area, [parts = std::move(parts), area](double u, double v, Vec3& p, Vec3& n) {
            double at = u * area;
            size_t i = 0;
            while (i + 1 < parts.size() && at >= parts[i].area) at -= parts[i++].area;
            parts[i].at(std::min(at / parts[i].area, 1.0), v, p, n);
            return area;
          }};
}

// A flat part with the corner `at` and two edges, whose cross product points outward.
Part FaceOf(const Vec3& at, const Vec3& a, const Vec3& b, bool is_triangle = false) {
  const Vec3 cross = curv::Cross(a, b);
  const double area = std::sqrt(curv::Dot(cross, cross)) * (is_triangle ? 0.5 : 1.0);
  const Vec3 normal = (1.0 / std::sqrt(curv::Dot(cross, cross))) * cross;
  return {area, [=](double u, double v, Vec3& p, Vec3& n) {
            if (is_triangle && u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
            p = at + u * a + v * b;
            n = normal;
          }};
}

// The ring between two radii around the z axis, at a height; `up` is 1 or -1.
Part RingOf(double inner, double outer, double height, double up) {
  return {kPi * (outer * outer - inner * inner), [=](double u, double v, Vec3& p, Vec3& n) {
            const double r = std::sqrt(inner * inner + u * (outer * outer - inner * inner)), t = 2 * kPi * v;
            p = {r * std::cos(t), r * std::sin(t), height};
            n = {0, 0, up};
          }};
}

// The wall around the z axis from one height to the other; `out` is 1, or -1 where the body is outside.
Part WallOf(double radius, double low, double high, double out) {
  return {2 * kPi * radius * (high - low), [=](double u, double v, Vec3& p, Vec3& n) {
            const double t = 2 * kPi * v;
            p = {radius * std::cos(t), radius * std::sin(t), low + u * (high - low)};
            n = {out * std::cos(t), out * std::sin(t), 0};
          }};
}

// A part of a sphere around a point of the z axis, between two cosines.
Part CapOf(double radius, double height, double low, double high) {
  return {2 * kPi * radius * radius * (high - low), [=](double u, double v, Vec3& p, Vec3& n) {
            const double z = low + u * (high - low), r = std::sqrt(std::max(1 - z * z, 0.0)), t = 2 * kPi * v;
            n = {r * std::cos(t), r * std::sin(t), z};
            p = radius * n + Vec3{0, 0, height};
          }};
}

// Bodies that are `thickness` spacings thin somewhere if they have so many points.
std::vector<Patch> Bodies(size_t points, double thickness) {
  const double count = static_cast<double>(points);
  std::vector<Patch> bodies;
  {
    const double r = 0.5 * thickness, half = std::max((count - 4 * kPi * r * r) / (4 * kPi * r), 0.0);
    bodies.push_back(BodyOf(absl::StrFormat("rod, %g thick", thickness),
                            {WallOf(r, -half, half, 1), CapOf(r, half, 0, 1), CapOf(r, -half, -1, 0)}));
  }
  {
    const double a = std::sqrt(count / 4.0), t = thickness;  // 2 a by a by t
    const Vec3 x{2 * a, 0, 0}, y{0, a, 0}, z{0, 0, t}, o{0, 0, 0};
    bodies.push_back(
        BodyOf(absl::StrFormat("board, %g thick", thickness),
               {FaceOf(o, y, x), FaceOf(z, x, y), FaceOf(o, x, z), FaceOf(y, z, x), FaceOf(o, z, y), FaceOf(x, y, z)}));
  }
  {
    const double a = std::sqrt(count / 2.0), t = thickness;  // the back is t thick
    const Vec3 x{a, 0, 0}, y{0, a, 0}, z{0, 0, t}, o{0, 0, 0};
    bodies.push_back(BodyOf(absl::StrFormat("wedge, %g thick", thickness),
                            {FaceOf(o, y, x), FaceOf(z, x + Vec3{0, 0, -t}, y), FaceOf(o, z, y), FaceOf(o, x, z, true),
                             FaceOf(y, z, x, true)}));
  }
  {
    const double t = thickness, r = std::sqrt(count / (8.0 * kPi)) + 0.5 * t, h = r;  // height 2 r
    bodies.push_back(
        BodyOf(absl::StrFormat("pipe, %g thick", thickness),
               {WallOf(r, -h, h, 1), WallOf(r - t, -h, h, -1), RingOf(r - t, r, h, 1), RingOf(r - t, r, -h, -1)}));
  }
  {
    const double r = std::sqrt(count / (8.0 * kPi)), gap = 0.5 * thickness;
    bodies.push_back(BodyOf(absl::StrFormat("two balls, %g apart", thickness),
                            {CapOf(r, r + gap, -1, 1), CapOf(r, -r - gap, -1, 1)}));
  }
  {
    const double t = thickness, r = std::sqrt(count / (4.0 * kPi)), z = 0.5 * t;
    bodies.push_back(BodyOf(absl::StrFormat("washer, %g thick", thickness),
                            {RingOf(0.5 * r, 1.3 * r, z, 1), RingOf(0.5 * r, 1.3 * r, -z, -1),
                             WallOf(1.3 * r, -z, z, 1), WallOf(0.5 * r, -z, z, -1)}));
  }
  {
    const double t = thickness, r = std::sqrt(count / (4.0 * kPi)), z = 0.5 * t;  // half a ball, beside a plate
    bodies.push_back(
        BodyOf(absl::StrFormat("hat, %g thick", thickness), {CapOf(0.7 * r, z, 0, 1), RingOf(0.7 * r, 1.4 * r, z, 1),
                                                             RingOf(0, 1.4 * r, -z, -1), WallOf(1.4 * r, -z, z, 1)}));
  }
  return bodies;
}

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

// At random; or none nearer to another one of its sheet than 0.7 spacings.
Shape SampleOf(const Patch& patch, size_t points, uint64_t seed, bool is_apart = false) {
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

std::vector<Patch> Patches(bool is_check) {
  if (is_check) {
    return {TorusPatch(3, 1),
            TorusPatch(10, 1.5),
            EllipsoidPatch(4, 3, 1),
            EllipsoidPatch(1, 1, 1.5),
            EllipsoidPatch(6, 1, 1),
            HeightPatch("monkey saddle", [](double x, double y) { return 0.4 * (x * x * x - 3 * x * y * y); }),
            HeightPatch("dune", [](double x, double y) { return 0.3 * std::sin(4 * x + y) * std::cos(2 * y); }),
            CylinderPatch(1, 3),
            BowlPatch(0.35)};
  }
  return {TorusPatch(6, 2),
          TorusPatch(4, 1),
          EllipsoidPatch(1, 1, 1),
          EllipsoidPatch(3, 2, 1),
          EllipsoidPatch(2, 2, 0.7),
          HeightPatch("saddle", [](double x, double y) { return 0.5 * (x * x - y * y); }),
          HeightPatch("plane", [](double, double) { return 0.0; }),
          HeightPatch("waves", [](double x, double y) { return 0.15 * std::sin(5 * x) * std::sin(4 * y); }),
          CylinderPatch(1, 1),
          BowlPatch(0.5)};
}

struct Found {
  double flipped;
  NormalReport report;
};

std::vector<float> Packed(const std::vector<Vec3>& positions) {
  std::vector<float> packed;
  for (const Vec3& p : positions) {
    for (const double c : {p.x, p.y, p.z}) packed.push_back(static_cast<float>(c));
  }
  return packed;
}

Found Try(const Shape& shape, WorkerPool& pool, const char* dump) {
  const std::vector<float> positions = Packed(shape.samples.positions);
  Cloud cloud(ScalarType::kFloat32, InvalidPointPolicy::kReject, NormalsInput::kAbsent);
  absl::Status status =
      cloud.Append({reinterpret_cast<const char*>(positions.data()), positions.size() * sizeof(float)}, {});
  if (status.ok()) status = cloud.Finish();
  NormalOptions options;
  options.source = NormalSource::kEstimate;
  auto made = MakeNormals(std::move(cloud), options, pool);
  if (!made.ok()) {
    std::fprintf(stderr, "%s\n", made.status().ToString().c_str());
    std::exit(1);
  }
  double flipped = 0.0, count = 0.0;
  std::FILE* file = dump != nullptr ? std::fopen(dump, "w") : nullptr;
  for (size_t i = 0; i < shape.samples.positions.size(); ++i) {
    const PointNormal& point = made->normals[i];
    const Vec3 normal{point.normal[0], point.normal[1], point.normal[2]};
    const double dot = curv::Dot(normal, shape.samples.normals[i]);
    if (file != nullptr) {
      const Vec3 p = shape.samples.positions[i], t = shape.samples.normals[i];
      std::fprintf(file, "%g %g %g %g %g %g %g %g %g %d\n", p.x, p.y, p.z, t.x, t.y, t.z, normal.x, normal.y, normal.z,
                   static_cast<int>(point.status));
    }
    if (point.status != PointStatus::kOk) continue;
    flipped += dot < 0.0 ? 1.0 : 0.0;
    ++count;
  }
  if (file != nullptr) std::fclose(file);
  double share = flipped / count;
  if (shape.is_open) share = std::min(share, 1.0 - share);
  return {share, made->report};
}

struct Totals {
  int clouds = 0, wrong = 0, missed = 0, false_alarms = 0, right = 0;
};

void Report(const Shape& shape, uint64_t seed, double noise, WorkerPool& pool, const char* dump, Totals& totals) {
  const Found found = Try(shape, pool, dump);
  const NormalReport& r = found.report;
  const bool is_wrong = found.flipped > 0.02, is_doubtful = r.is_doubtful();
  ++totals.clouds;
  totals.wrong += is_wrong;
  totals.missed += is_wrong && !is_doubtful;
  totals.right += found.flipped <= 0.005;
  totals.false_alarms += found.flipped <= 0.005 && is_doubtful;
  absl::PrintF(
      "%-40s %7d %3d %5.2f  %6.2f %% %6.3f of %5.3f %-8s %5s %4d  %d/%d closed %.2f repaired %d turned %.4f opposed "
      "%.3f torn %.4f %s\n",
      shape.name, shape.samples.positions.size(), seed, noise, 100.0 * found.flipped, r.certificate.value_or(-1.0),
      r.max_trusted_certificate, is_doubtful ? "doubtful" : "", std::string(NormalMethodName(*r.method)),
      r.neighbor_count, r.closed_piece_count, r.piece_count, r.closed_area_share, r.repaired_count,
      r.turned_share.value_or(-1.0), r.opposed_share.value_or(-1.0), r.torn_share.value_or(-1.0),
      is_wrong && !is_doubtful                ? "MISSED"
      : found.flipped <= 0.005 && is_doubtful ? "FALSE"
                                              : "");
  std::fflush(stdout);
}

int Main(int argc, char** argv) {
  CLI::App app("Sides of normals made of positions: how many are wrong, and whether the certificate tells");
  std::string only, dump;
  double added_noise = 0.0;
  bool is_check = false, bodies = false, plates = false, shells = false, noisy = false, is_apart = false;
  std::vector<size_t> sizes;
  std::vector<double> levels;
  std::vector<uint64_t> seeds = {1};
  app.add_flag("--plates", plates, "Thin closed plates");
  app.add_flag("--shells", shells, "Thin bodies that are round: lenses, hollow balls, pots");
  app.add_flag("--bodies", bodies, "Thin bodies of other kinds");
  app.add_option("--noise", added_noise, "Noise of plates, shells and bodies, in spacings");
  app.add_flag("--noisy", noisy, "Small noisy clouds");
  app.add_flag("--apart", is_apart, "Shells and noisy clouds of points that keep apart, before noise");
  app.add_flag("--check", is_check, "Clouds by which nothing was chosen");
  app.add_option("--sizes", sizes, "Points");
  app.add_option("--levels", levels, "Noise of noisy clouds, thickness of plates and shells; in spacings");
  app.add_option("--seeds", seeds, "Of the clouds");
  app.add_option("--only", only, "Part of the name of the clouds that are tried");
  app.add_option("--dump", dump, "File for the last cloud: positions, true normals, normals, status");
  CLI11_PARSE(app, argc, argv);
  WorkerPool pool(2);
  Totals totals;
  const auto try_it = [&](Shape shape, uint64_t seed, double noise) {
    if (noise == 0.0 && added_noise > 0.0) {
      noise = added_noise;
      curv::AddPositionNoise(noise, seed, shape.samples.positions);
    }
    if (shape.name.find(only) == std::string::npos) return;
    Report(shape, seed, noise, pool, dump.empty() ? nullptr : dump.c_str(), totals);
  };
  if (plates) {
    const std::vector<std::string> outlines = is_check ? std::vector<std::string>{"triangle", "strip", "star"}
                                                       : std::vector<std::string>{"square", "disk", "bracket"};
    for (const size_t points : sizes.empty() ? std::vector<size_t>{5000, 20'000} : sizes) {
      for (const std::string& outline : outlines) {
        for (const double thickness : levels.empty() ? std::vector<double>{0.7, 1.0, 1.5, 2.0, 3.0} : levels) {
          for (const Sampling sampling : {Sampling::kShaken, Sampling::kRandom, Sampling::kLattice}) {
            for (const uint64_t seed : seeds) {
              Shape plate = Plate(outline, points, thickness, sampling, seed);
              if (seed % 2 == 0 || is_check) Tilt(0.3 + static_cast<double>(seed), plate.samples);
              try_it(plate, seed, 0.0);
            }
          }
        }
      }
    }
  }
  if (shells) {
    for (const size_t points : sizes.empty() ? std::vector<size_t>{900, 5000, 20'000} : sizes) {
      for (const double thickness : levels.empty() ? std::vector<double>{2.0, 3.0, 4.0, 6.0} : levels) {
        const std::vector<Patch> bodies =
            is_check ? std::vector<Patch>{PotPatch(points, thickness, 0.35), PotPatch(points, thickness, 0.8)}
                     : std::vector<Patch>{LensPatch(points, thickness), HollowPatch(points, thickness),
                                          PotPatch(points, thickness, 0.6)};
        for (const Patch& body : bodies) {
          for (const uint64_t seed : seeds) {
            Shape shell = SampleOf(body, points, seed, is_apart);
            Tilt(0.3 + static_cast<double>(seed), shell.samples);
            try_it(shell, seed, 0.0);
          }
        }
      }
    }
  }
  if (bodies) {
    for (const size_t points : sizes.empty() ? std::vector<size_t>{900, 5000} : sizes) {
      for (const double thickness : levels.empty() ? std::vector<double>{0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0} : levels) {
        for (const Patch& body : Bodies(points, thickness)) {
          for (const uint64_t seed : seeds) {
            Shape shape = SampleOf(body, points, seed, is_apart);
            Tilt(0.3 + static_cast<double>(seed), shape.samples);
            try_it(std::move(shape), seed, 0.0);
          }
        }
      }
    }
  }
  if (noisy) {
    for (const size_t points : sizes.empty() ? std::vector<size_t>{300, 1000, 3000, 10'000} : sizes) {
      for (const Patch& patch : Patches(is_check)) {
        for (const double noise : levels.empty() ? std::vector<double>{0.0, 0.3, 0.7, 1.0, 1.5} : levels) {
          for (const uint64_t seed : seeds) {
            Shape cloud = SampleOf(patch, points, seed, is_apart);
            if (noise > 0.0) curv::AddPositionNoise(noise, seed, cloud.samples.positions);
            try_it(cloud, seed, noise);
          }
        }
      }
    }
  }
  absl::PrintF(
      "%d clouds; %d of them with more than 2 %% turned, %d of these without a warning; %d with at most 0.5 %%, %d of "
      "these with one\n",
      totals.clouds, totals.wrong, totals.missed, totals.right, totals.false_alarms);
  return 0;
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) { return curvd::bench::Main(argc, argv); }
