// Symbols as in Guennebaud, Gross 2007 and Ponca: the algebraic sphere s(x) = uc + ul x + uq x^2, positions relative
// to the query.
#include "bench/peers/plain_tensor.h"

namespace curvd::bench {
namespace {

using Eigen::RowVector3d;

// Weighted sums over the neighbors, and their derivatives by the place of the weights' center.
struct SphereSums {
  double w = 0.0, pn = 0.0, pp = 0.0;
  Vector3d p = Vector3d::Zero(), n = Vector3d::Zero();
  RowVector3d dw = RowVector3d::Zero(), dpn = RowVector3d::Zero(), dpp = RowVector3d::Zero();
  Matrix3d dp = Matrix3d::Zero(), dn = Matrix3d::Zero();

  void Add(const Vector3d& position, const Vector3d& normal, double squared_radius) {
    const double squared = position.squaredNorm(), t = 1.0 - squared / squared_radius;
    if (t <= 0.0) return;
    const double weight = t * t, position_normal = position.dot(normal);
    const RowVector3d gradient = (4.0 * t / squared_radius) * position.transpose();
    w += weight;
    p += weight * position;
    n += weight * normal;
    pn += weight * position_normal;
    pp += weight * squared;
    dw += gradient;
    dp += position * gradient;
    dn += normal * gradient;
    dpn += position_normal * gradient;
    dpp += squared * gradient;
  }
};

// The unit normal of the sphere's level set at the query, and its derivative.
struct ShapeOperator {
  Vector3d normal;
  Matrix3d derivative;
};

ShapeOperator Differentiate(const SphereSums& s) {
  const double numerator = s.pn - s.p.dot(s.n) / s.w;
  const double denominator = s.pp - s.p.squaredNorm() / s.w;
  const double uq = 0.5 * numerator / denominator;
  const Vector3d ul = (s.n - 2.0 * uq * s.p) / s.w;
  const RowVector3d d_numerator =
      s.dpn - (s.p.transpose() * s.dn + s.n.transpose() * s.dp) / s.w + s.p.dot(s.n) / (s.w * s.w) * s.dw;
  const RowVector3d d_denominator =
      s.dpp - 2.0 / s.w * (s.p.transpose() * s.dp) + s.p.squaredNorm() / (s.w * s.w) * s.dw;
  const RowVector3d d_uq = (0.5 * d_numerator - uq * d_denominator) / denominator;
  const Matrix3d d_ul = (s.dn - 2.0 * uq * s.dp - 2.0 * s.p * d_uq - ul * s.dw) / s.w;
  // The gradient of s at x is ul + 2 uq x; at the query x is 0, but its derivative is not.
  const Matrix3d d_gradient = d_ul + 2.0 * uq * Matrix3d::Identity();
  const double length = ul.norm();
  const Vector3d normal = ul / length;
  return {normal, (d_gradient - normal * (normal.transpose() * d_gradient)) / length};
}

PointCurvature CurvatureOf(const ShapeOperator& shape, double radius) {
  const Frame frame = TangentFrame(shape.normal);
  Eigen::Matrix<double, 3, 2> basis;
  basis << frame.u, frame.v;
  const Eigen::Matrix2d tangent = basis.transpose() * shape.derivative * basis;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(0.5 * (tangent + tangent.transpose()));
  const double k1 = solver.eigenvalues()[0], k2 = solver.eigenvalues()[1];
  PointCurvature out;
  out.mean = static_cast<float>(0.5 * (k1 + k2));
  out.gaussian = static_cast<float>(k1 * k2);
  out.k1 = static_cast<float>(k1);
  out.k2 = static_cast<float>(k2);
  Store(basis * solver.eigenvectors().col(0), out.d1);
  Store(basis * solver.eigenvectors().col(1), out.d2);
  out.radius = static_cast<float>(radius);
  out.status = PointStatus::kOk;
  return out;
}

}  // namespace

void RunPlainShapeOperator(const PeerCloud& cloud, const PeerNeighbors& neighbors, PointCurvature* out) {
  for (size_t i = 0; i < neighbors.size(); ++i) {
    const Vector3d origin = Triple(cloud.positions, i);
    const double squared_radius = neighbors.radii[i] * neighbors.radii[i];
    SphereSums sums;
    for (uint32_t j : neighbors.of(i)) {
      sums.Add(Triple(cloud.positions, j) - origin, Triple(cloud.normals, j), squared_radius);
    }
    out[i] = CurvatureOf(Differentiate(sums), neighbors.radii[i]);
  }
}

}  // namespace curvd::bench
