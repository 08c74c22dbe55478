#include "core/least_axis.h"

#include <Eigen/Eigenvalues>

namespace curvd {

void LeastAxis(const double* covariance, double* axis) {
  Eigen::Matrix3d matrix;                 // the solver reads the lower triangle
  matrix << covariance[0], 0.0, 0.0,      //
      covariance[1], covariance[3], 0.0,  //
      covariance[2], covariance[4], covariance[5];
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(matrix);
  Eigen::Map<Eigen::Vector3d>(axis, 3) = solver.eigenvectors().col(0);
}

}  // namespace curvd
