#include "client/surfaces/surface.h"

#include <algorithm>

namespace curv {
namespace {

// H v for the symmetric matrix H.
Vec3 Multiply(const ImplicitJet& jet, const Vec3& v) {
  const Vec3& diagonal = jet.hessian_diagonal;
  const Vec3& off = jet.hessian_off_diagonal;
  return {diagonal.x * v.x + off.z * v.y + off.y * v.z, off.z * v.x + diagonal.y * v.y + off.x * v.z,
          off.y * v.x + off.x * v.y + diagonal.z * v.z};
}

// A unit vector orthogonal to the unit vector n: n x e with e the axis farthest from n.
Vec3 AnyTangent(const Vec3& n) {
  const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  const Vec3 axis = x <= y && x <= z ? Vec3{1, 0, 0} : y <= z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  return Normalized(Cross(n, axis));
}

}  // namespace

SurfaceGeometry Surface::At(const Vec3& position) const {
  const ImplicitJet jet = Jet(position);
  const double slope = Norm(jet.gradient);
  const Vec3 normal = (1.0 / slope) * jet.gradient;
  const Vec3 u = AnyTangent(normal);
  const Vec3 v = Cross(normal, u);

  // The shape operator dn in the frame (u, v) is the Hessian restricted to the tangent plane, over |gradient|.
  const Vec3 hessian_u = Multiply(jet, u);
  const double a = Dot(u, hessian_u) / slope;
  const double b = Dot(v, hessian_u) / slope;
  const double c = Dot(v, Multiply(jet, v)) / slope;

  const double mean = 0.5 * (a + c);
  const double half_gap = std::hypot(0.5 * (a - c), b);
  // Twice the angle from u to the direction of the larger curvature.
  const double double_angle = std::atan2(2.0 * b, a - c);
  const double cosine = std::cos(0.5 * double_angle), sine = std::sin(0.5 * double_angle);
  const Vec3 d2 = cosine * u + sine * v;
  return {.normal = normal,
          .mean = mean,
          .gaussian = a * c - b * b,
          .k1 = mean - half_gap,
          .k2 = mean + half_gap,
          .d1 = Cross(d2, normal),
          .d2 = d2};
}

Vec3 Surface::Project(Vec3 position) const {
  constexpr int kMaxSteps = 16;
  const double size = Norm(bounds().high - bounds().low);
  for (int step = 0; step < kMaxSteps; ++step) {
    Vec3 gradient;
    const double value = Evaluate(position, gradient);
    const double squared_slope = Dot(gradient, gradient);
    if (squared_slope == 0.0) break;
    position += (-value / squared_slope) * gradient;
    // Newton squares the relative error: after a step of 1e-8, what is left is below rounding.
    if (value * value <= 1e-16 * size * size * squared_slope) break;
  }
  return position;
}

Vec3 Surface::ProjectWithin(const Vec3& position) const {
  // Going to and fro between the surface and the box at least halves the way where they meet at 45 degrees or more.
  constexpr int kMaxRounds = 60;
  Vec3 result = Project(position);
  const Box box = bounds();
  for (int round = 0; round < kMaxRounds && DistanceToBorder(result) < 0.0; ++round) {
    for (int axis = 0; axis < 3; ++axis) {
      if (is_open(axis)) result[axis] = std::clamp(result[axis], box.low[axis], box.high[axis]);
    }
    const Vec3 projected = Project(result);
    if (Norm(projected - result) <= 1e-15 * Norm(box.high - box.low)) break;
    result = projected;
  }
  return result;
}

double Surface::DistanceToBorder(const Vec3& position) const {
  const Box box = bounds();
  double distance = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (!is_open(axis)) continue;
    distance = std::min({distance, position[axis] - box.low[axis], box.high[axis] - position[axis]});
  }
  return distance;
}

}  // namespace curv
