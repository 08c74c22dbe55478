// The measures of the paper in plain doubles with Eigen, as the authors' code has them: the whole 3x3 tensor, the part
// along the normal pushed away, eigenvectors by the standard solver.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>

#include "bench/peers/plain_peers.h"

namespace curvd::bench {

using Eigen::Matrix3d;
using Eigen::Vector3d;

inline Vector3d Triple(std::span<const double> triples, size_t i) { return Vector3d::Map(&triples[3 * i]); }

struct Corner {
  Vector3d position, normal;
};

struct Measures {
  double area = 0.0, mean = 0.0, gaussian = 0.0;
  Matrix3d tensor = Matrix3d::Zero();
};

// Property 1, with 1/4 in the mean measure; a triangle that faces away from its normals is turned.
inline void AddTriangle(const Corner& a, const Corner& b, const Corner& c, Measures& sum) {
  const Vector3d w = (a.normal + b.normal + c.normal) / 3.0;
  const Vector3d e1 = b.position - a.position, e2 = c.position - a.position;
  const Vector3d n1 = b.normal - a.normal, n2 = c.normal - a.normal;
  const double area = 0.5 * w.dot(e1.cross(e2));
  const double turn = area < 0.0 ? -1.0 : 1.0;
  sum.area += turn * area;
  sum.mean += turn * 0.25 * w.dot(n1.cross(e2) - n2.cross(e1));
  sum.gaussian += turn * 0.5 * a.normal.dot(b.normal.cross(c.normal));
  // tensor(X, Y) for all X and Y at once: <w, X x e2> = <X, e2 x w>.
  sum.tensor += (turn * 0.5) * (e2.cross(w) * n1.transpose() - e1.cross(w) * n2.transpose());
}

inline void Store(const Vector3d& v, std::array<float, 3>& out) {
  for (int axis = 0; axis < 3; ++axis) out[static_cast<size_t>(axis)] = static_cast<float>(v[axis]);
}

// The eigenvalues but the one that belongs to the unit normal u, which is made by far the largest.
inline PointCurvature CurvatureOf(const Measures& m, const Vector3d& u, double radius) {
  const Matrix3d symmetric = 0.5 * (m.tensor + m.tensor.transpose()) + 1000.0 * m.area * u * u.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(symmetric);
  PointCurvature out;
  out.mean = static_cast<float>(m.mean / m.area);
  out.gaussian = static_cast<float>(m.gaussian / m.area);
  out.k1 = static_cast<float>(solver.eigenvalues()[0] / m.area);
  out.k2 = static_cast<float>(solver.eigenvalues()[1] / m.area);
  Store(solver.eigenvectors().col(0), out.d1);
  Store(solver.eigenvectors().col(1), out.d2);
  out.radius = static_cast<float>(radius);
  out.status = PointStatus::kOk;
  return out;
}

struct Frame {
  Vector3d u, v;
};

// u = n x e with e the axis after the largest component of n, v = n x u.
inline Frame TangentFrame(const Vector3d& n) {
  Eigen::Index largest;
  n.cwiseAbs().maxCoeff(&largest);
  const Vector3d u = n.cross(Vector3d::Unit((largest + 1) % 3)).normalized();
  return {u, n.cross(u)};
}

// Half the point's own normal, half the mean of its neighbors'; unit.
inline Vector3d BlendedNormal(const PeerCloud& cloud, size_t i, std::span<const uint32_t> neighbors) {
  Vector3d sum = Vector3d::Zero();
  for (uint32_t j : neighbors) sum += Triple(cloud.normals, j);
  return (0.5 * Triple(cloud.normals, i) + 0.5 / static_cast<double>(neighbors.size()) * sum).normalized();
}

}  // namespace curvd::bench
