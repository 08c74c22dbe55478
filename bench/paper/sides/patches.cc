#include "bench/paper/sides/patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "absl/strings/str_format.h"

namespace curvd::bench {
namespace {

using curv::Vec3;

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

}  // namespace

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

std::vector<Patch> Shells(size_t points, double thickness, bool is_check) {
  if (is_check) return {PotPatch(points, thickness, 0.35), PotPatch(points, thickness, 0.8)};
  return {LensPatch(points, thickness), HollowPatch(points, thickness), PotPatch(points, thickness, 0.6)};
}

}  // namespace curvd::bench
