#include "bench/paper/held_out_surfaces.h"

#include <cmath>
#include <numbers>

namespace curvd::bench {
namespace {

using curv::Box;
using curv::Dot;
using curv::ImplicitJet;
using curv::Vec3;

// f = s^2 - 2 (x^2 - y^2 - z^2) + 1 - b^4 with s = x^2 + y^2 + z^2 and b^2 = 1.21.
class Peanut : public curv::Surface {
 public:
  std::string_view name() const override { return "peanut"; }
  Box bounds() const override { return {{-1.6, -0.7, -0.7}, {1.6, 0.7, 0.7}}; }
  double Evaluate(const Vec3& p, Vec3& gradient) const override {
    const double s = Dot(p, p);
    gradient = {4.0 * p.x * (s - 1.0), 4.0 * p.y * (s + 1.0), 4.0 * p.z * (s + 1.0)};
    return s * s - 2.0 * (p.x * p.x - p.y * p.y - p.z * p.z) + 1.0 - kProduct * kProduct;
  }
  ImplicitJet Jet(const Vec3& p) const override {
    const double s = Dot(p, p);
    ImplicitJet jet;
    jet.value = Evaluate(p, jet.gradient);
    jet.hessian_diagonal = {4.0 * s + 8.0 * p.x * p.x - 4.0, 4.0 * s + 8.0 * p.y * p.y + 4.0,
                            4.0 * s + 8.0 * p.z * p.z + 4.0};
    jet.hessian_off_diagonal = {8.0 * p.y * p.z, 8.0 * p.x * p.z, 8.0 * p.x * p.y};
    return jet;
  }

 private:
  static constexpr double kProduct = 1.21;
};

class Lumpy : public curv::Surface {
 public:
  std::string_view name() const override { return "lumpy"; }
  Box bounds() const override { return {{-1.2, -1.2, -1.2}, {1.2, 1.2, 1.2}}; }
  double Evaluate(const Vec3& p, Vec3& gradient) const override {
    gradient = {2.0 * p.x + kLump * p.y * p.z, 2.0 * p.y + kLump * p.x * p.z, 2.0 * p.z + kLump * p.x * p.y};
    return Dot(p, p) + kLump * p.x * p.y * p.z - 1.0;
  }
  ImplicitJet Jet(const Vec3& p) const override {
    ImplicitJet jet;
    jet.value = Evaluate(p, jet.gradient);
    jet.hessian_diagonal = {2.0, 2.0, 2.0};
    jet.hessian_off_diagonal = kLump * p;
    return jet;
  }

 private:
  static constexpr double kLump = 0.6;
};

class Pillow : public curv::Surface {
 public:
  std::string_view name() const override { return "pillow"; }
  Box bounds() const override { return {{-2.1, -1.1, -1.1}, {2.1, 1.1, 1.1}}; }
  double Evaluate(const Vec3& p, Vec3& gradient) const override {
    gradient = {0.25 * p.x * p.x * p.x, 2.0 * p.y, 2.0 * p.z};
    return 0.25 * gradient.x * p.x + p.y * p.y + p.z * p.z - 1.0;
  }
  ImplicitJet Jet(const Vec3& p) const override {
    ImplicitJet jet;
    jet.value = Evaluate(p, jet.gradient);
    jet.hessian_diagonal = {0.75 * p.x * p.x, 2.0, 2.0};
    return jet;
  }
};

class Catenoid : public curv::Surface {
 public:
  std::string_view name() const override { return "catenoid"; }
  Box bounds() const override { return {{-2.0, -2.0, -1.2}, {2.0, 2.0, 1.2}}; }
  bool is_open(int axis) const override { return axis == 2; }
  double Evaluate(const Vec3& p, Vec3& gradient) const override {
    gradient = {2.0 * p.x, 2.0 * p.y, -std::sinh(2.0 * p.z)};
    return p.x * p.x + p.y * p.y - std::cosh(p.z) * std::cosh(p.z);
  }
  ImplicitJet Jet(const Vec3& p) const override {
    ImplicitJet jet;
    jet.value = Evaluate(p, jet.gradient);
    jet.hessian_diagonal = {2.0, 2.0, -2.0 * std::cosh(2.0 * p.z)};
    return jet;
  }
};

class Gyroid : public curv::Surface {
 public:
  std::string_view name() const override { return "gyroid"; }
  Box bounds() const override { return {{-2.2, -2.2, -2.2}, {2.2, 2.2, 2.2}}; }
  bool is_open(int /*axis*/) const override { return true; }
  double Evaluate(const Vec3& p, Vec3& gradient) const override {
    const Vec3 sine{std::sin(p.x), std::sin(p.y), std::sin(p.z)}, cosine{std::cos(p.x), std::cos(p.y), std::cos(p.z)};
    gradient = {cosine.x * cosine.y - sine.z * sine.x, cosine.y * cosine.z - sine.x * sine.y,
                cosine.z * cosine.x - sine.y * sine.z};
    return sine.x * cosine.y + sine.y * cosine.z + sine.z * cosine.x;
  }
  ImplicitJet Jet(const Vec3& p) const override {
    const Vec3 sine{std::sin(p.x), std::sin(p.y), std::sin(p.z)}, cosine{std::cos(p.x), std::cos(p.y), std::cos(p.z)};
    ImplicitJet jet;
    jet.value = Evaluate(p, jet.gradient);
    jet.hessian_diagonal = {-sine.x * cosine.y - sine.z * cosine.x, -sine.y * cosine.z - sine.x * cosine.y,
                            -sine.z * cosine.x - sine.y * cosine.z};
    jet.hessian_off_diagonal = {-cosine.y * sine.z, -cosine.z * sine.x, -cosine.x * sine.y};
    return jet;
  }
};

// f = (x^2 + y^2 + z^2 - 1) / 2 - the sum of h sin(k . p + phase) over waves in directions that are spread evenly.
class Hammered : public curv::Surface {
 public:
  std::string_view name() const override { return "hammered"; }
  Box bounds() const override { return {{-1.1, -1.1, -1.1}, {1.1, 1.1, 1.1}}; }
  double Evaluate(const Vec3& p, Vec3& gradient) const override {
    const ImplicitJet jet = Jet(p);
    gradient = jet.gradient;
    return jet.value;
  }
  ImplicitJet Jet(const Vec3& p) const override {
    ImplicitJet jet;
    jet.value = 0.5 * (Dot(p, p) - 1.0);
    jet.gradient = p;
    jet.hessian_diagonal = {1.0, 1.0, 1.0};
    for (int i = 0; i < kWaves; ++i) {
      const double z = (i + 0.5) / kWaves, turn = kGoldenAngle * i, r = kWaveNumber * std::sqrt(1.0 - z * z);
      const Vec3 k{r * std::cos(turn), r * std::sin(turn), kWaveNumber * z};
      const double at = Dot(k, p) + i * i, height = kHeight * std::sin(at), slope = kHeight * std::cos(at);
      jet.value -= height;
      jet.gradient = jet.gradient - slope * k;
      jet.hessian_diagonal = jet.hessian_diagonal + height * Vec3{k.x * k.x, k.y * k.y, k.z * k.z};
      jet.hessian_off_diagonal = jet.hessian_off_diagonal + height * Vec3{k.y * k.z, k.x * k.z, k.x * k.y};
    }
    return jet;
  }

 private:
  static constexpr int kWaves = 12;
  static constexpr double kGoldenAngle = 2.39996322972865332, kWaveNumber = 2.0 * std::numbers::pi / 0.2;
  // Waves whose slope has a root mean square of 0.15 in all.
  static constexpr double kHeight = 0.15 / kWaveNumber * 0.408;
};

}  // namespace

std::unique_ptr<curv::Surface> MakeHeldOutSurface(std::string_view name) {
  if (name == "peanut") return std::make_unique<Peanut>();
  if (name == "lumpy") return std::make_unique<Lumpy>();
  if (name == "pillow") return std::make_unique<Pillow>();
  if (name == "catenoid") return std::make_unique<Catenoid>();
  if (name == "gyroid") return std::make_unique<Gyroid>();
  if (name == "hammered") return std::make_unique<Hammered>();
  return nullptr;
}

}  // namespace curvd::bench
