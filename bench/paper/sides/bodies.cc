#include "bench/paper/sides/bodies.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <utility>

#include "absl/strings/str_format.h"

namespace curvd::bench {
namespace {

using curv::Vec3;

constexpr double kPi = std::numbers::pi;

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

}  // namespace

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

}  // namespace curvd::bench
