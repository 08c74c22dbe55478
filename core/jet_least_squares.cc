#include "core/jet_least_squares.h"

#include <Eigen/QR>

namespace curvd {
namespace {

constexpr double kMinRelativePivot = 1e-6;

Eigen::Vector3d VectorOf(const GroupDoubleVectors& vectors, size_t i) {
  return {vectors.x[i], vectors.y[i], vectors.z[i]};
}

}  // namespace

bool SolveJetByQr(const NeighborArrays& neighbors, size_t i, double unit, int degree, JetSystems& jets) {
  const Eigen::Vector3d u = VectorOf(jets.u, i), v = VectorOf(jets.v, i), axis = VectorOf(jets.axis, i);
  const auto count = static_cast<Eigen::Index>(neighbors.count);
  Eigen::MatrixXd monomials(count, JetSize(degree));
  Eigen::VectorXd heights(count);
  for (Eigen::Index row = 0; row < count; ++row) {
    const auto j = static_cast<size_t>(row);
    const Eigen::Vector3d offset = unit * Eigen::Vector3d(neighbors.dx[j], neighbors.dy[j], neighbors.dz[j]);
    const double x = offset.dot(u), y = offset.dot(v);
    heights[row] = offset.dot(axis);
    monomials(row, 0) = 1.0;
    for (int k = 1; k <= degree; ++k) {
      for (int b = 0; b < k; ++b) monomials(row, JetIndex(k - b, b)) = x * monomials(row, JetIndex(k - 1 - b, b));
      monomials(row, JetIndex(0, k)) = y * monomials(row, JetIndex(0, k - 1));
    }
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(monomials);
  qr.setThreshold(kMinRelativePivot);
  if (qr.rank() < monomials.cols()) return false;
  const Eigen::VectorXd solution = qr.solve(heights);
  for (int c = 0; c < JetSize(degree); ++c) jets.coefficients[c][i] = solution[c];
  return true;
}

}  // namespace curvd
