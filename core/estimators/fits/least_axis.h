// The direction in which points spread least.
#pragma once

namespace curvd {

// Writes the unit eigenvector of the smallest eigenvalue of a symmetric matrix (xx, xy, xz, yy, yz, zz) to axis[0..2].
// Any unit vector, the same for the same matrix, where the eigenvalue is not simple.
void LeastAxis(const double* covariance, double* axis);

}  // namespace curvd
