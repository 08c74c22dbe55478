#include "core/scale/shapes/sphere_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "Eigen/Core"
#include "Eigen/Geometry"
#include "Eigen/LU"
#include "core/estimators/fits/sphere_sums.h"
#include "core/scale/shapes/field_limits.h"

namespace curvd {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using M = SphereMoments;

// Neighbors more than a sphere has coefficients.
constexpr double kLeastDistinct = 5.0 + 3.0;

// Sums in units of the radius.
class UnitMoments {
 public:
  UnitMoments(const SphereMoments& moments, double radius) : moments_(moments) {
    powers_[0] = 1.0;
    for (size_t k = 1; k < powers_.size(); ++k) powers_[k] = powers_[k - 1] / radius;
  }

  double One(size_t left) const { return At(left, M::kOne, 0); }
  Vector3d Offset(size_t left) const {
    return {At(left, M::kOffset, 1), At(left, M::kOffset + 1, 1), At(left, M::kOffset + 2, 1)};
  }
  Vector3d Normal(size_t left) const {
    return {At(left, M::kNormal, 0), At(left, M::kNormal + 1, 0), At(left, M::kNormal + 2, 0)};
  }
  double OffsetNormal(size_t left) const { return At(left, M::kOffsetNormal, 1); }
  double Sixth() const { return moments_.sixth() * powers_[6]; }

 private:
  double At(size_t left, size_t right, size_t degree) const {
    return moments_.sum(left, right) * powers_[M::kLeftDegrees[left] + degree];
  }
  const SphereMoments& moments_;
  std::array<double, 7> powers_;
};

// Sums of 1, q, n, q n and q q with some factor, in units of the radius.
struct FactoredSums {
  double one;
  Vector3d q, n;
  double qn, qq;
};

// With the weights w = (1 - |q|^2)^2.
FactoredSums Weighted(const UnitMoments& sums) {
  const auto of = [&](const auto& at) { return (at(M::kPlain) - 2.0 * at(M::kSquared) + at(M::kFourth)).eval(); };
  const auto number = [&](const auto& at) { return at(M::kPlain) - 2.0 * at(M::kSquared) + at(M::kFourth); };
  return {number([&](size_t left) { return sums.One(left); }), of([&](size_t left) { return sums.Offset(left); }),
          of([&](size_t left) { return sums.Normal(left); }),
          number([&](size_t left) { return sums.OffsetNormal(left); }),
          sums.One(M::kSquared) - 2.0 * sums.One(M::kFourth) + sums.Sixth()};
}

// With the weights' derivatives 4 (1 - |q|^2) q along an axis.
FactoredSums WeightedBySlope(const UnitMoments& sums, int axis) {
  const size_t linear = M::kLinear + static_cast<size_t>(axis), cubic = M::kCubic + static_cast<size_t>(axis);
  return {4.0 * (sums.One(linear) - sums.One(cubic)), 4.0 * (sums.Offset(linear) - sums.Offset(cubic)),
          4.0 * (sums.Normal(linear) - sums.Normal(cubic)),
          4.0 * (sums.OffsetNormal(linear) - sums.OffsetNormal(cubic)),
          4.0 * (sums.One(cubic) - sums.Offset(M::kFourth)[axis])};
}

// The place among xx xy xz yy yz zz.
constexpr size_t ProductOf(int a, int b) {
  const int low = a < b ? a : b, high = a < b ? b : a;
  return M::kProducts + static_cast<size_t>(low == 0 ? high : low + high + 1);
}

// How the sphere's constant depends on the weight of a neighbor, but for the sum of all weights.
struct Influence {
  double constant, by_qn, by_qq;
  Vector3d by_q, by_n;

  double Of(const Vector3d& q, const Vector3d& n) const {
    return constant + by_q.dot(q) + by_n.dot(n) + by_qn * q.dot(n) + by_qq * q.squaredNorm();
  }
  // The sum of the influences, times a left factor of the moments; `squares` is that of |q|^2 times it.
  double Sum(const UnitMoments& sums, size_t left, double squares) const {
    return constant * sums.One(left) + by_q.dot(sums.Offset(left)) + by_n.dot(sums.Normal(left)) +
           by_qn * sums.OffsetNormal(left) + by_qq * squares;
  }
};

// The sum of the influences times the weights' second derivatives 8 q q' - 4 (1 - |q|^2) I. Those at the rim have none.
Matrix3d InfluenceHessian(const UnitMoments& sums, const Influence& influence, std::span<const PilotNeighbor> rim,
                          double radius) {
  Matrix3d products;
  for (int a = 0; a < 3; ++a) {
    for (int b = a; b < 3; ++b) {
      const size_t cubic = M::kCubic + static_cast<size_t>(a);
      products(a, b) = products(b, a) = influence.Sum(sums, ProductOf(a, b), sums.Offset(cubic)[b]);
    }
  }
  for (const PilotNeighbor& neighbor : rim) {
    const Vector3d q = Vector3d(neighbor.offset.data()) / radius, n(neighbor.normal.data());
    products -= influence.Of(q, n) * q * q.transpose();
  }
  const double trace =
      influence.Sum(sums, M::kPlain, sums.One(M::kSquared)) - influence.Sum(sums, M::kSquared, sums.One(M::kFourth));
  return 8.0 * products - 4.0 * trace * Matrix3d::Identity();
}

}  // namespace

// The symbols are those of core/estimators/fits/algebraic_sphere-inl.h; rows of derivatives are along x, y and z.
std::optional<TangentShape> SphereShapeOf(const SphereMoments& moments, std::span<const PilotNeighbor> rim,
                                          double distinct, double radius) {
  if (distinct < kLeastDistinct) return std::nullopt;
  const UnitMoments sums(moments, radius);
  const FactoredSums w = Weighted(sums);
  if (!(w.one > 0.0)) return std::nullopt;
  const double per_weight = 1.0 / w.one;
  const Vector3d p = per_weight * w.q, m = per_weight * w.n;
  const double qn = per_weight * w.qn, qq = per_weight * w.qq, pp = p.squaredNorm(), pm = p.dot(m);
  const double variance = qq - pp;
  if (!(variance > kMinSphereVariance && m.squaredNorm() > kLeastSquaredMean)) return std::nullopt;
  const double s = 0.5 * (qn - pm) / variance, ratio = (qq - 2.0 * pp) / variance, mixed = 1.0 - 0.5 * ratio;
  Influence influence{0.0, -0.5 * ratio, s * (ratio - 1.0), -(mixed * m + s * (2.0 * ratio - 4.0) * p), -mixed * p};
  influence.constant = -(influence.by_q.dot(p) + influence.by_n.dot(m) + influence.by_qn * qn + influence.by_qq * qq);

  Matrix3d p_slope, m_slope, second;
  Vector3d weight_slope, s_slope, c_slope, rest;
  for (int a = 0; a < 3; ++a) {
    const FactoredSums slope = WeightedBySlope(sums, a);
    const double of_weight = weight_slope[a] = per_weight * slope.one;
    second.row(a) = slope.q;
    p_slope.row(a) = per_weight * slope.q - of_weight * p;
    m_slope.row(a) = per_weight * slope.n - of_weight * m;
    const double qn_slope = per_weight * slope.qn - of_weight * qn, qq_slope = per_weight * slope.qq - of_weight * qq;
    const double p_p = p_slope.row(a).dot(p), p_m = p_slope.row(a).dot(m) + m_slope.row(a).dot(p);
    const double variance_slope = qq_slope - 2.0 * p_p, square_slope = qq_slope - 4.0 * p_p;
    s_slope[a] = (0.5 * (qn_slope - p_m) - s * variance_slope) / variance;
    c_slope[a] = -(p_m + s_slope[a] * ratio * variance) - s * square_slope;
    rest[a] = ratio * variance_slope - square_slope;
  }
  const Vector3d gradient = m - 2.0 * s * p + c_slope;
  Matrix3d hessian = per_weight * InfluenceHessian(sums, influence, rim, radius);
  hessian -= weight_slope * c_slope.transpose() + c_slope * weight_slope.transpose();
  const Matrix3d cross = p_slope * m_slope.transpose();
  hessian -= mixed * (cross + cross.transpose());
  hessian += 2.0 * s * (2.0 - ratio) * p_slope * p_slope.transpose();
  hessian += s_slope * rest.transpose() + rest * s_slope.transpose();
  hessian += m_slope + m_slope.transpose() - 2.0 * (p * s_slope.transpose() + s_slope * p.transpose());
  hessian -= 2.0 * s * (p_slope + p_slope.transpose());
  hessian.diagonal().array() += 2.0 * s;

  const double length = gradient.norm();
  const Vector3d n = gradient / length;
  if (!(n.z() > kLeastCosineToFrame)) return std::nullopt;
  const Vector3d tangent_x(1.0, 0.0, -n.x() / n.z()), tangent_y(0.0, 1.0, -n.y() / n.z());
  const Vector3d y = n.cross(tangent_x).normalized(), x = y.cross(n);
  const double xx = x.dot(second * x), xy = x.dot(second * y), yy = y.dot(second * y);
  if (!(xx * yy - xy * xy > kMinSphereVariance * (xx + yy) * (xx + yy))) return std::nullopt;
  // Back from the level of the field that the point lies on to the surface.
  const double c = -(pm + s * ratio * variance);
  const double outside = 2.0 * c / (length + std::sqrt(std::max(length * length - 4.0 * s * c, 0.0)));
  const Matrix3d along = Matrix3d::Identity() - n * n.transpose();
  const Matrix3d of_level = along * hessian * along / length;
  const Matrix3d stretch = Matrix3d::Identity() - outside * of_level;
  // The third eigenvalue, along n, is 1.
  const double sum = stretch.trace() - 1.0, product = stretch.determinant();
  if (!(0.5 * (sum - std::sqrt(std::max(sum * sum - 4.0 * product, 0.0))) > kLeastNearness)) return std::nullopt;
  const Matrix3d shape = of_level * stretch.inverse() / radius;
  return ShapeOf(tangent_x, tangent_y, shape * tangent_x, shape * tangent_y);
}

}  // namespace curvd
