#include "tests/core/reference_fits.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>

#include "tests/core/reference_measures.h"

namespace curvd::testing {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A tangent basis (u, v) with u x v = n.
Eigen::Matrix<double, 3, 2> TangentBasis(const Vector3d& n) {
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = n.unitOrthogonal();
  basis.col(1) = n.cross(basis.col(0));
  return basis;
}

// The direction in which the offsets spread least.
Vector3d PlaneNormal(const std::vector<Vector3d>& offsets) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& offset : offsets) mean += offset / static_cast<double>(offsets.size());
  Matrix3d covariance = Matrix3d::Zero();
  for (const Vector3d& offset : offsets) covariance += (offset - mean) * (offset - mean).transpose();
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(covariance).eigenvectors().col(0);
}

// A function of x with its first and second derivatives; sums and products follow the rules of calculus.
struct Jet2 {
  double value = 0.0;
  Vector3d gradient = Vector3d::Zero();
  Matrix3d hessian = Matrix3d::Zero();
};

Jet2 operator+(const Jet2& a, const Jet2& b) {
  return {a.value + b.value, a.gradient + b.gradient, a.hessian + b.hessian};
}
Jet2 operator*(const Jet2& a, const Jet2& b) {
  return {a.value * b.value, a.value * b.gradient + b.value * a.gradient,
          a.value * b.hessian + b.value * a.hessian + a.gradient * b.gradient.transpose() +
              b.gradient * a.gradient.transpose()};
}
Jet2 operator*(double s, const Jet2& a) { return {s * a.value, s * a.gradient, s * a.hessian}; }
Jet2 operator-(const Jet2& a, const Jet2& b) { return a + -1.0 * b; }
Jet2 Reciprocal(const Jet2& a) {
  const double r = 1.0 / a.value;
  return {r, -r * r * a.gradient, 2.0 * r * r * r * a.gradient * a.gradient.transpose() - r * r * a.hessian};
}
Jet2 Dot(const std::array<Jet2, 3>& a, const std::array<Jet2, 3>& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Weight of a neighbor as a function of the query point.
Jet2 Weight(const Vector3d& offset, double radius) {
  const Jet2 squared{offset.squaredNorm(), -2.0 * offset, 2.0 * Matrix3d::Identity()};
  const Jet2 one{1.0, Vector3d::Zero(), Matrix3d::Zero()};
  const Jet2 inner = one - 1.0 / (radius * radius) * squared;
  return inner.value > 1e-6 ? inner * inner : Jet2();
}

// The monomials of x and y up to a degree.
Eigen::RowVectorXd Monomials(const Eigen::Vector2d& x, int degree) {
  Eigen::RowVectorXd row((degree + 1) * (degree + 2) / 2);
  Eigen::Index column = 0;
  for (int k = 0; k <= degree; ++k) {
    for (int j = 0; j <= k; ++j) row[column++] = std::pow(x[0], k - j) * std::pow(x[1], j);
  }
  return row;
}

}  // namespace

ReferenceNeighborhood NeighborhoodOf(const TestPoints& points, size_t i, const std::vector<int>& ids) {
  ReferenceNeighborhood result;
  for (int id : ids) {
    Vector3d offset;
    for (int axis = 0; axis < 3; ++axis) offset[axis] = points.positions[id][axis] - points.positions[i][axis];
    result.offsets.push_back(offset);
    result.normals.push_back(ToVector(points.normals[id]));
  }
  result.own_normal = ToVector(points.normals[i]);
  return result;
}

std::optional<Eigen::Matrix2d> JetShapeOperator(const ReferenceNeighborhood& neighborhood, int degree) {
  const Vector3d axis = PlaneNormal(neighborhood.offsets);
  const Eigen::Matrix<double, 3, 2> plane = TangentBasis(axis);
  double unit = 0.0;
  for (const Vector3d& offset : neighborhood.offsets) unit = std::max(unit, offset.norm());
  const auto rows = static_cast<Eigen::Index>(neighborhood.offsets.size());
  const Eigen::Index columns = (degree + 1) * (degree + 2) / 2;
  if (rows < columns) return std::nullopt;
  Eigen::MatrixXd monomials(rows, columns);
  Eigen::VectorXd heights(rows);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const Vector3d offset = neighborhood.offsets[static_cast<size_t>(row)] / unit;
    const Eigen::Vector2d x = plane.transpose() * offset;
    monomials.row(row) = Monomials(x, degree);
    heights[row] = axis.dot(offset);
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(monomials, Eigen::ComputeThinU | Eigen::ComputeThinV);
  if (svd.singularValues()[columns - 1] < 1e-5 * svd.singularValues()[0]) return std::nullopt;
  const Eigen::VectorXd c = svd.solve(heights);

  // Fundamental forms of (x, y, height) at the query point.
  const Eigen::Vector2d slope(c[1], c[2]);
  const Eigen::Matrix2d first = Eigen::Matrix2d::Identity() + slope * slope.transpose();
  Eigen::Matrix2d second;
  second << 2.0 * c[3], c[4], c[4], 2.0 * c[5];
  second /= std::sqrt(1.0 + slope.squaredNorm()) * unit;
  const Vector3d normal = axis - plane * slope;
  // With the root of the first form as change of basis, the operator is symmetric.
  const Eigen::Matrix2d root = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(first).operatorInverseSqrt();
  return (normal.dot(neighborhood.own_normal) < 0.0 ? 1.0 : -1.0) * root * second * root;
}

std::optional<Eigen::Matrix2d> AlgebraicShapeOperator(const ReferenceNeighborhood& neighborhood, double radius,
                                                      bool project) {
  Jet2 weight, products, squares;
  std::array<Jet2, 3> position, normal;
  for (size_t j = 0; j < neighborhood.offsets.size(); ++j) {
    const Vector3d &q = neighborhood.offsets[j], &n = neighborhood.normals[j];
    const Jet2 w = Weight(q, radius);
    weight = weight + w;
    products = products + q.dot(n) * w;
    squares = squares + q.squaredNorm() * w;
    for (int axis = 0; axis < 3; ++axis) {
      position[axis] = position[axis] + q[axis] * w;
      normal[axis] = normal[axis] + n[axis] * w;
    }
  }
  // The sphere c + l y + s y y about the query point, by its normal equations.
  const Jet2 per_weight = Reciprocal(weight);
  const Jet2 variance = squares - per_weight * Dot(position, position);
  if (variance.value < 1e-5 * weight.value * radius * radius) return std::nullopt;
  const Jet2 s = 0.5 * (products - per_weight * Dot(position, normal)) * Reciprocal(variance);
  std::array<Jet2, 3> l;
  for (int axis = 0; axis < 3; ++axis) l[axis] = per_weight * (normal[axis] - 2.0 * s * position[axis]);
  const Jet2 c = -1.0 * (per_weight * (Dot(l, position) + s * squares));

  // f(x) = c(x) + l(x) y + s(x) y y at y = x, where the offset y is 0 with derivative I.
  Vector3d gradient = c.gradient;
  Matrix3d hessian = c.hessian + 2.0 * s.value * Matrix3d::Identity();
  for (int axis = 0; axis < 3; ++axis) {
    gradient[axis] += l[axis].value;
    hessian.row(axis) += l[axis].gradient.transpose();
    hessian.col(axis) += l[axis].gradient;
  }
  if (gradient.dot(neighborhood.own_normal) <= 0.0) return std::nullopt;
  const Eigen::Matrix<double, 3, 2> plane = TangentBasis(gradient.normalized());
  const Eigen::Matrix2d level = plane.transpose() * hessian * plane / gradient.norm();
  if (!project) return level;
  // The level's principal radii are larger than the surface's by its distance from the surface.
  const double outside =
      2.0 * c.value / (gradient.norm() + std::sqrt(gradient.squaredNorm() - 4.0 * s.value * c.value));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(level);
  const Eigen::Array2d k = solver.eigenvalues().array();
  if ((1.0 - outside * k).minCoeff() < 0.1) return std::nullopt;
  const Eigen::Matrix2d axes = solver.eigenvectors();
  return axes * (k / (1.0 - outside * k)).matrix().asDiagonal() * axes.transpose();
}

std::optional<Eigen::Matrix2d> NormalRegressionOperator(const ReferenceNeighborhood& neighborhood, double radius,
                                                        const Vector3d& axis, int degree) {
  const Eigen::Matrix<double, 3, 2> plane = TangentBasis(axis);
  const auto rows = static_cast<Eigen::Index>(neighborhood.offsets.size());
  const Eigen::Index columns = (degree + 1) * (degree + 2) / 2;
  if (rows < columns) return std::nullopt;
  Eigen::MatrixXd monomials(rows, columns), normals(rows, 3);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const auto j = static_cast<size_t>(row);
    const Eigen::Vector2d x = plane.transpose() * neighborhood.offsets[j] / radius;
    const double root = std::sqrt(std::max(1.0 - x.squaredNorm(), 0.0));
    monomials.row(row) = root * Monomials(x, degree);
    normals.row(row) = root * neighborhood.normals[j].transpose();
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(monomials, Eigen::ComputeThinU | Eigen::ComputeThinV);
  if (svd.singularValues()[columns - 1] < 1e-4 * svd.singularValues()[0]) return std::nullopt;
  const Eigen::MatrixXd c = svd.solve(normals);

  // A surface over the plane that has the fitted normal at the point, its tangents along x and y, and its forms.
  const Vector3d normal = c.row(0).normalized().transpose();
  if (c.row(0).dot(axis) < 0.1) return std::nullopt;
  Eigen::Matrix<double, 3, 2> tangents, derivatives;
  for (int a = 0; a < 2; ++a) {
    tangents.col(a) = plane.col(a) - plane.col(a).dot(normal) / axis.dot(normal) * axis;
    derivatives.col(a) = c.row(1 + a).transpose() / (c.row(0).norm() * radius);
  }
  const Eigen::Matrix2d first = tangents.transpose() * tangents;
  const Eigen::Matrix2d product = tangents.transpose() * derivatives;
  const Eigen::Matrix2d second = 0.5 * (product + product.transpose());
  const Eigen::Matrix2d root = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(first).operatorInverseSqrt();
  return root * second * root;
}

namespace {

// Coefficients of the normals' components, a column each: the value at the query point, then the derivatives. Normals
// along `own` do not change with a weight of `ridge` neighbors, and along any axis with one of `least`.
Eigen::Matrix<double, 4, 3> FitLinearField(const ReferenceNeighborhood& neighborhood, double ridge, double least) {
  const auto count = static_cast<Eigen::Index>(neighborhood.offsets.size());
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(count + 4, 4), normals = Eigen::MatrixXd::Zero(count + 4, 3);
  for (Eigen::Index row = 0; row < count; ++row) {
    const auto j = static_cast<size_t>(row);
    design.row(row) << 1.0, neighborhood.offsets[j].transpose();
    normals.row(row) = neighborhood.normals[j].transpose();
  }
  design.block<1, 3>(count, 1) = std::sqrt(ridge) * neighborhood.own_normal.transpose();
  design.block<3, 3>(count + 1, 1).diagonal().setConstant(std::sqrt(least));
  return Eigen::JacobiSVD<Eigen::MatrixXd>(design, Eigen::ComputeThinU | Eigen::ComputeThinV).solve(normals);
}

// The mean product of the normals with those of the field.
double Explained(const ReferenceNeighborhood& neighborhood, const Eigen::Matrix<double, 4, 3>& field) {
  double sum = 0.0;
  for (size_t j = 0; j < neighborhood.offsets.size(); ++j) {
    const Vector3d fitted = field.row(0).transpose() + field.bottomRows<3>().transpose() * neighborhood.offsets[j];
    sum += neighborhood.normals[j].dot(fitted);
  }
  return sum / static_cast<double>(neighborhood.offsets.size());
}

}  // namespace

std::optional<Eigen::Matrix2d> LinearRegressionOperator(const ReferenceNeighborhood& neighborhood) {
  const double count = static_cast<double>(neighborhood.offsets.size());
  if (count < 8.0) return std::nullopt;
  Vector3d mean = Vector3d::Zero(), mean_normal = Vector3d::Zero();
  for (size_t j = 0; j < neighborhood.offsets.size(); ++j) {
    mean += neighborhood.offsets[j] / count;
    mean_normal += neighborhood.normals[j] / count;
  }
  Matrix3d offsets = Matrix3d::Zero(), products = Matrix3d::Zero();
  for (size_t j = 0; j < neighborhood.offsets.size(); ++j) {
    const Vector3d q = neighborhood.offsets[j] - mean;
    offsets += q * q.transpose() / count;
    products += (neighborhood.normals[j] - mean_normal) * q.transpose() / count;
  }
  const Eigen::Matrix<double, 3, 2> own_plane = TangentBasis(neighborhood.own_normal);
  const double trace = offsets.trace(), least = 1e-9 * count * trace;
  const double left = 0.5 * std::max(1.0 - Explained(neighborhood, FitLinearField(neighborhood, 0.0, least)), 0.0);
  const double variance = 0.5 * (own_plane.transpose() * offsets * own_plane).trace();
  const double bend = (own_plane.transpose() * products * own_plane).squaredNorm() / (2.0 * variance * variance);
  const double ridge = bend > 0.0 ? std::min(left / ((count - 4.0) * bend), trace) : trace;

  const Eigen::Matrix<double, 4, 3> field = FitLinearField(neighborhood, count * ridge, least);
  const Vector3d at_point = field.row(0).transpose();
  if (at_point.dot(neighborhood.own_normal) <= 0.0) return std::nullopt;
  const Eigen::Matrix<double, 3, 2> plane = TangentBasis(at_point.normalized());
  const Eigen::Matrix2d spread = plane.transpose() * offsets * plane;
  if (spread.determinant() < 1e-4 * spread.trace() * spread.trace()) return std::nullopt;
  const Eigen::Matrix2d shape =
      plane.transpose() * field.bottomRows<3>().transpose() * plane / std::sqrt(Explained(neighborhood, field));
  return 0.5 * (shape + shape.transpose());
}

}  // namespace curvd::testing
