// The surfaces that MakeSurface knows: an implicit function each.
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/surfaces/surface.h"

namespace curv {
namespace {

// f = x^2 / a^2 + y^2 / b^2 + z^2 / c^2 - 1, a term of which vanishes for an infinite semi-axis.
class Quadric : public Surface {
 public:
  Quadric(std::string_view name, Vec3 inverse_squares, Box bounds, bool open_in_z)
      : name_(name), inverse_squares_(inverse_squares), bounds_(bounds), open_in_z_(open_in_z) {}

  std::string_view name() const override { return name_; }
  Box bounds() const override { return bounds_; }
  bool is_open(int axis) const override { return axis == 2 && open_in_z_; }
  double Evaluate(const Vec3& p, Vec3& gradient) const override {
    gradient = {2 * p.x * inverse_squares_.x, 2 * p.y * inverse_squares_.y, 2 * p.z * inverse_squares_.z};
    return 0.5 * Dot(gradient, p) - 1.0;
  }
  ImplicitJet Jet(const Vec3& p) const override {
    ImplicitJet jet;
    jet.hessian_diagonal = 2.0 * inverse_squares_;
    jet.value = Evaluate(p, jet.gradient);
    return jet;
  }

 private:
  std::string_view name_;
  Vec3 inverse_squares_;
  Box bounds_;
  bool open_in_z_;
};

// f = (rho - R)^2 + z^2 - r^2 with rho = |(x, y)|.
class Torus : public Surface {
 public:
  std::string_view name() const override { return "torus"; }
  Box bounds() const override { return {{-8, -8, -2}, {8, 8, 2}}; }
  double Evaluate(const Vec3& p, Vec3& gradient) const override {
    const double rho = std::hypot(p.x, p.y);
    const double outward = 2.0 * (rho - kCircle) / rho;
    gradient = {outward * p.x, outward * p.y, 2.0 * p.z};
    return (rho - kCircle) * (rho - kCircle) + p.z * p.z - kTube * kTube;
  }
  ImplicitJet Jet(const Vec3& p) const override {
    const double rho = std::hypot(p.x, p.y);
    const double around = 2.0 * (rho - kCircle) / rho;  // second derivative along the circle; across it, it is 2
    const double c = p.x / rho, s = p.y / rho;
    ImplicitJet jet;
    jet.hessian_diagonal = {2 * c * c + around * s * s, 2 * s * s + around * c * c, 2};
    jet.hessian_off_diagonal = {0, 0, (2 - around) * c * s};
    jet.value = Evaluate(p, jet.gradient);
    return jet;
  }

 private:
  static constexpr double kCircle = 6.0;
  static constexpr double kTube = 2.0;
};

// f = 0.03 (x^4 + y^4 + z^4) - 2 (x^2 + y^2 + z^2) - 8.
class Goursat : public Surface {
 public:
  std::string_view name() const override { return "goursat"; }
  // The largest coordinate is 9.6609, where the squares of the two others are 100 / 3.
  Box bounds() const override { return {{-10, -10, -10}, {10, 10, 10}}; }
  double Evaluate(const Vec3& p, Vec3& gradient) const override {
    double value = -8.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double square = p[axis] * p[axis];
      value += square * (0.03 * square - 2.0);
      gradient[axis] = p[axis] * (0.12 * square - 4.0);
    }
    return value;
  }
  ImplicitJet Jet(const Vec3& p) const override {
    ImplicitJet jet;
    jet.value = Evaluate(p, jet.gradient);
    for (int axis = 0; axis < 3; ++axis) jet.hessian_diagonal[axis] = 0.36 * p[axis] * p[axis] - 4.0;
    return jet;
  }
};

// f = z - s (x^2 - y^2) / 2: a saddle for s = 1, the plane for s = 0.
class Graph : public Surface {
 public:
  Graph(std::string_view name, double bend, Box bounds) : name_(name), bend_(bend), bounds_(bounds) {}

  std::string_view name() const override { return name_; }
  Box bounds() const override { return bounds_; }
  bool is_open(int axis) const override { return axis != 2; }
  double Evaluate(const Vec3& p, Vec3& gradient) const override {
    gradient = {-bend_ * p.x, bend_ * p.y, 1.0};
    return p.z - 0.5 * bend_ * (p.x * p.x - p.y * p.y);
  }
  ImplicitJet Jet(const Vec3& p) const override {
    ImplicitJet jet;
    jet.hessian_diagonal = {-bend_, bend_, 0};
    jet.value = Evaluate(p, jet.gradient);
    return jet;
  }

 private:
  std::string_view name_;
  double bend_;
  Box bounds_;
};

}  // namespace

std::vector<std::string_view> SurfaceNames() {
  return {"sphere", "torus", "cylinder", "saddle", "goursat", "ellipsoid", "plane"};
}

absl::StatusOr<std::unique_ptr<Surface>> MakeSurface(std::string_view name) {
  std::unique_ptr<Surface> surface;
  if (name == "sphere") {
    surface = std::make_unique<Quadric>("sphere", Vec3{1, 1, 1}, Box{{-1, -1, -1}, {1, 1, 1}}, false);
  } else if (name == "torus") {
    surface = std::make_unique<Torus>();
  } else if (name == "cylinder") {
    surface = std::make_unique<Quadric>("cylinder", Vec3{1, 1, 0}, Box{{-1, -1, -2}, {1, 1, 2}}, true);
  } else if (name == "saddle") {
    surface = std::make_unique<Graph>("saddle", 1.0, Box{{-1, -1, -0.5}, {1, 1, 0.5}});
  } else if (name == "goursat") {
    surface = std::make_unique<Goursat>();
  } else if (name == "ellipsoid") {
    surface = std::make_unique<Quadric>("ellipsoid", Vec3{1.0 / 9, 1.0 / 4, 1}, Box{{-3, -2, -1}, {3, 2, 1}}, false);
  } else if (name == "plane") {
    surface = std::make_unique<Graph>("plane", 0.0, Box{{-1, -1, 0}, {1, 1, 0}});
  } else {
    return absl::InvalidArgumentError(absl::StrCat(
        "surface \"", std::string(name), "\" is not known: it must be one of ",
        absl::StrJoin(SurfaceNames(), ", ", [](std::string* out, std::string_view known) { out->append(known); })));
  }
  return surface;
}

}  // namespace curv
