#include "core/estimators/fits/jet_least_squares.h"

#include <algorithm>
#include <numeric>
#include <tuple>

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

// Doubles of the matrix, the heights and the order.
size_t RoomFor(size_t neighbor_count, int degree) { return neighbor_count * static_cast<size_t>(JetSize(degree) + 2); }

// Writes the neighbors' indices in an order that does not depend on that of the tree. Those that it does not tell apart
// make equal rows.
void SetOrder(const NeighborArrays& neighbors, size_t* order) {
  std::iota(order, order + neighbors.count, size_t{0});
  std::sort(order, order + neighbors.count, [&](size_t a, size_t b) {
    return std::tie(neighbors.dx[a], neighbors.dy[a], neighbors.dz[a]) <
           std::tie(neighbors.dx[b], neighbors.dy[b], neighbors.dz[b]);
  });
}

}  // namespace

bool SolveJetByQr(const NeighborArrays& neighbors, size_t i, double unit, int degree, ScratchArray<double>& room,
                  JetSystems& jets) {
  constexpr double kMinRelativePivot = 1e-6;
  const auto rows = static_cast<Eigen::Index>(neighbors.count), columns = static_cast<Eigen::Index>(JetSize(degree));
  room.Reserve(RoomFor(neighbors.count, degree));
  Eigen::Map<Eigen::MatrixXd> matrix(room.data(), rows, columns);
  Eigen::Map<Eigen::VectorXd> heights(room.data() + rows * columns, rows);
  static_assert(sizeof(size_t) == sizeof(double));
  auto* const order = reinterpret_cast<size_t*>(room.data() + rows * (columns + 1));
  SetOrder(neighbors, order);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const size_t j = order[row];
    const auto along = [&](const GroupDoubleVectors& axis) {
      return unit * (neighbors.dx[j] * axis.x[i] + neighbors.dy[j] * axis.y[i] + neighbors.dz[j] * axis.z[i]);
    };
    SetMonomials(along(jets.u), along(jets.v), degree, matrix.row(row));
    heights[row] = along(jets.axis);
  }
  Eigen::ColPivHouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(matrix);
  qr.setThreshold(kMinRelativePivot);
  if (qr.rank() < columns) return false;
  // What qr.solve(heights) does, but for its copies of the heights.
  heights.applyOnTheLeft(qr.householderQ().setLength(columns).adjoint());
  qr.matrixR().topLeftCorner(columns, columns).triangularView<Eigen::Upper>().solveInPlace(heights.head(columns));
  for (Eigen::Index c = 0; c < columns; ++c) {
    jets.coefficients[qr.colsPermutation().indices()[c]][i] = heights[c];
  }
  return true;
}

size_t JetQrBytes(size_t neighbor_count, int degree) {
  // Eigen's own vectors are few and of the length of a row.
  return ScratchArray<double>::MostBytes(RoomFor(neighbor_count, degree)) +
         12 * static_cast<size_t>(JetSize(degree)) * sizeof(double);
}

}  // namespace curvd
