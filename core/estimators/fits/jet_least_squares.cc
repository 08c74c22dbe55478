#include "core/estimators/fits/jet_least_squares.h"

#include "Eigen/QR"

namespace curvd {
namespace {

// Sets the row of a jet's matrix: the monomials of x and y, by JetIndex.
void SetMonomials(double x, double y, int degree, Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> row) {
  row[0] = 1.0;
  for (int k = 1; k <= degree; ++k) {
    for (int b = 0; b < k; ++b) row[JetIndex(k - b, b)] = x * row[JetIndex(k - b - 1, b)];
    row[JetIndex(0, k)] = y * row[JetIndex(0, k - 1)];
  }
}

}  // namespace

bool SolveJetByQr(const NeighborArrays& neighbors, size_t i, double unit, int degree, JetSystems& jets) {
  constexpr double kMinRelativePivot = 1e-6;
  const auto rows = static_cast<Eigen::Index>(neighbors.count);
  Eigen::MatrixXd matrix(rows, JetSize(degree));
  Eigen::VectorXd heights(rows);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const auto j = static_cast<size_t>(row);
    const auto along = [&](const GroupDoubleVectors& axis) {
      return unit * (neighbors.dx[j] * axis.x[i] + neighbors.dy[j] * axis.y[i] + neighbors.dz[j] * axis.z[i]);
    };
    SetMonomials(along(jets.u), along(jets.v), degree, matrix.row(row));
    heights[row] = along(jets.axis);
  }
  Eigen::ColPivHouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(matrix);
  qr.setThreshold(kMinRelativePivot);
  if (qr.rank() < JetSize(degree)) return false;
  const Eigen::VectorXd coefficients = qr.solve(heights);
  for (int c = 0; c < JetSize(degree); ++c) jets.coefficients[c][i] = coefficients[c];
  return true;
}

size_t JetQrBytes(size_t neighbor_count, int degree) {
  // The matrix, two vectors of heights, and a few of the length of a row.
  const auto columns = static_cast<size_t>(JetSize(degree));
  return (neighbor_count * (columns + 2) + 12 * columns) * sizeof(double);
}

}  // namespace curvd
