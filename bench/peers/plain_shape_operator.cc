// Symbols as in Guennebaud, Gross 2007 and Ponca: the algebraic sphere s(x) = uc + ul x + uq x^2, positions relative
// to the query. Its coefficients depend on the query through the weights, and so does the field f, its value at the
// query; the shape operator is that of f's level set.
#include "bench/peers/plain_tensor.h"

namespace curvd::bench {
namespace {

// A number that depends on the place of the weights' center, with its derivatives there.
struct Differentiable {
  double value = 0.0;
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();

  void Add(double factor, const Differentiable& other) {
    value += factor * other.value;
    first += factor * other.first;
    second += factor * other.second;
  }
};

Differentiable Sum(const Differentiable& a, double factor, const Differentiable& b) {
  Differentiable sum = a;
  sum.Add(factor, b);
  return sum;
}

Differentiable Product(const Differentiable& a, const Differentiable& b) {
  const Matrix3d mixed = a.first * b.first.transpose();
  return {a.value * b.value, a.value * b.first + b.value * a.first,
          a.value * b.second + b.value * a.second + mixed + mixed.transpose()};
}

// a / b
Differentiable Quotient(const Differentiable& a, const Differentiable& b) {
  Differentiable out;
  out.value = a.value / b.value;
  out.first = (a.first - out.value * b.first) / b.value;
  const Matrix3d mixed = out.first * b.first.transpose();
  out.second = (a.second - out.value * b.second - mixed - mixed.transpose()) / b.value;
  return out;
}

// Weighted sums over the neighbors.
struct SphereSums {
  Differentiable w, pn, pp;
  Differentiable p[3], n[3];

  void Add(const Vector3d& position, const Vector3d& normal, double squared_radius) {
    const double squared = position.squaredNorm(), t = 1.0 - squared / squared_radius;
    if (t < 1e-6) return;  // the rim, where the second derivative jumps
    Differentiable weight;
    weight.value = t * t;
    weight.first = 4.0 * t / squared_radius * position;
    weight.second = 8.0 / (squared_radius * squared_radius) * position * position.transpose();
    weight.second.diagonal().array() -= 4.0 * t / squared_radius;
    w.Add(1.0, weight);
    pn.Add(position.dot(normal), weight);
    pp.Add(squared, weight);
    for (int axis = 0; axis < 3; ++axis) {
      p[axis].Add(position[axis], weight);
      n[axis].Add(normal[axis], weight);
    }
  }
};

Differentiable Dot(const Differentiable* a, const Differentiable* b) {
  return Sum(Sum(Product(a[0], b[0]), 1.0, Product(a[1], b[1])), 1.0, Product(a[2], b[2]));
}

// The unit normal of the field's level set at the query, and its derivative.
struct ShapeOperator {
  Vector3d normal;
  Matrix3d derivative;
};

ShapeOperator Differentiate(const SphereSums& s) {
  const Differentiable numerator = Sum(s.pn, -1.0, Quotient(Dot(s.p, s.n), s.w));
  const Differentiable denominator = Sum(s.pp, -1.0, Quotient(Dot(s.p, s.p), s.w));
  const Differentiable twice_uq = Quotient(numerator, denominator);
  Differentiable ul[3];
  for (int axis = 0; axis < 3; ++axis) {
    ul[axis] = Quotient(Sum(s.n[axis], -1.0, Product(twice_uq, s.p[axis])), s.w);
  }
  const Differentiable uc = Quotient(Sum(Dot(ul, s.p), 0.5, Product(twice_uq, s.pp)), s.w);  // negated
  // At the query x is 0, but its derivative is not.
  Vector3d gradient = -uc.first;
  Matrix3d hessian = -uc.second + twice_uq.value * Matrix3d::Identity();
  for (int axis = 0; axis < 3; ++axis) {
    gradient[axis] += ul[axis].value;
    hessian.row(axis) += ul[axis].first;
    hessian.col(axis) += ul[axis].first;
  }
  const double length = gradient.norm();
  const Vector3d normal = gradient / length;
  return {normal, (hessian - normal * (normal.transpose() * hessian)) / length};
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
