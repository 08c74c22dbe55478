#include "tests/core/reference_measures.h"

#include <cmath>

namespace curvd::testing {

using Eigen::Vector3d;

void ReferenceMeasures::AddTriangle(const ReferenceCorner& a, const ReferenceCorner& b, const ReferenceCorner& c,
                                    const Vector3d axes[2], double weight) {
  const Vector3d w = (a.normal + b.normal + c.normal) / 3.0;
  const Vector3d e1 = b.position - a.position, e2 = c.position - a.position;
  const double turned_area = 0.5 * w.dot(e1.cross(e2));
  const double turn = turned_area < 0 ? -weight : weight;
  area += turn * turned_area;
  mean += turn * 0.25 *
          w.dot((c.normal - b.normal).cross(a.position) + (a.normal - c.normal).cross(b.position) +
                (b.normal - a.normal).cross(c.position));
  const double turned_gaussian = turn * 0.5 * a.normal.dot(b.normal.cross(c.normal));
  gaussian += turned_gaussian;
  gaussian_magnitude += std::abs(turned_gaussian);
  for (int x = 0; x < 2; ++x) {
    for (int y = 0; y < 2; ++y) {
      tensor(x, y) += turn * 0.5 *
                      w.dot(axes[y].dot(b.normal - a.normal) * axes[x].cross(e2) -
                            axes[y].dot(c.normal - a.normal) * axes[x].cross(e1));
    }
  }
}

void ReferenceMeasures::ToCurvature(ReferenceCurvature& out) const {
  out.mean = mean / area;
  out.gaussian = gaussian / area;
  out.gaussian_magnitude = gaussian_magnitude / area;
  const Eigen::Matrix2d symmetric = 0.5 / area * (tensor + tensor.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(symmetric, Eigen::EigenvaluesOnly);
  const double half_difference = 0.5 * (solver.eigenvalues()[1] - solver.eigenvalues()[0]);
  out.k1 = out.mean - half_difference;
  out.k2 = out.mean + half_difference;
}

void TangentAxes(const Vector3d& n, Vector3d axes[2]) {
  int largest = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (std::abs(n[axis]) > std::abs(n[largest])) largest = axis;
  }
  axes[0] = n.cross(Vector3d::Unit((largest + 1) % 3)).normalized();
  axes[1] = n.cross(axes[0]);
}

}  // namespace curvd::testing
