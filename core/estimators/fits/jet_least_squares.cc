#include "core/estimators/fits/jet_least_squares.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace curvd {
namespace {

constexpr double kMinRelativePivot = 1e-6;

// Columns of equal length: the monomials of a jet at each neighbor, and the heights.
class JetMatrix {
 public:
  JetMatrix(const NeighborArrays& neighbors, size_t i, double unit, int degree, const JetSystems& jets)
      : rows_(neighbors.count), size_(static_cast<size_t>(JetSize(degree))), entries_(rows_ * (size_ + 1)) {
    const auto along = [&](const GroupDoubleVectors& axis, size_t row) {
      return unit * (neighbors.dx[row] * axis.x[i] + neighbors.dy[row] * axis.y[i] + neighbors.dz[row] * axis.z[i]);
    };
    for (size_t row = 0; row < rows_; ++row) {
      const double x = along(jets.u, row), y = along(jets.v, row);
      const auto monomial = [&](int a, int b) -> double& { return column(static_cast<size_t>(JetIndex(a, b)))[row]; };
      monomial(0, 0) = 1.0;
      for (int k = 1; k <= degree; ++k) {
        for (int b = 0; b < k; ++b) monomial(k - b, b) = x * monomial(k - b - 1, b);
        monomial(0, k) = y * monomial(0, k - 1);
      }
      heights()[row] = along(jets.axis, row);
    }
  }

  size_t rows() const { return rows_; }
  size_t size() const { return size_; }
  double* column(size_t c) { return entries_.data() + c * rows_; }
  double* heights() { return column(size_); }

 private:
  size_t rows_;
  size_t size_;
  std::vector<double> entries_;
};

double SquaredNorm(const double* column, size_t from, size_t to) {
  return std::inner_product(column + from, column + to, column + from, 0.0);
}

// Reflects `column` by the Householder vector v, whose entries start at `from`.
void Reflect(const double* v, double half_squared_norm, size_t from, size_t to, double* column) {
  const double share = std::inner_product(v + from, v + to, column + from, 0.0) / half_squared_norm;
  for (size_t row = from; row < to; ++row) column[row] -= share * v[row];
}

// Makes the matrix upper triangular, its diagonal in `diagonal`, its columns in the order of falling pivots; returns
// that order, or nothing if it is singular. The heights are reflected with it.
std::vector<size_t> Triangulate(JetMatrix& matrix, std::vector<double>& diagonal) {
  std::vector<size_t> order(matrix.size());
  std::iota(order.begin(), order.end(), size_t{0});
  diagonal.resize(matrix.size());
  for (size_t step = 0; step < matrix.size(); ++step) {
    const auto rest = [&](size_t c) { return SquaredNorm(matrix.column(c), step, matrix.rows()); };
    const auto longest = std::max_element(order.begin() + static_cast<std::ptrdiff_t>(step), order.end(),
                                          [&](size_t a, size_t b) { return rest(a) < rest(b); });
    std::swap(order[step], *longest);
    double* v = matrix.column(order[step]);
    const double length = std::sqrt(rest(order[step]));
    if (step > 0 && length < kMinRelativePivot * std::abs(diagonal[0])) return {};
    diagonal[step] = v[step] > 0.0 ? -length : length;
    const double half_squared_norm = length * (length + std::abs(v[step]));
    v[step] -= diagonal[step];
    for (size_t c = step + 1; c < matrix.size(); ++c) {
      Reflect(v, half_squared_norm, step, matrix.rows(), matrix.column(order[c]));
    }
    Reflect(v, half_squared_norm, step, matrix.rows(), matrix.heights());
  }
  return order;
}

}  // namespace

bool SolveJetByQr(const NeighborArrays& neighbors, size_t i, double unit, int degree, JetSystems& jets) {
  JetMatrix matrix(neighbors, i, unit, degree, jets);
  std::vector<double> diagonal;
  const std::vector<size_t> order = Triangulate(matrix, diagonal);
  if (order.empty()) return false;
  double* heights = matrix.heights();
  for (size_t step = matrix.size(); step-- > 0;) {
    const double coefficient = heights[step] / diagonal[step];
    jets.coefficients[order[step]][i] = coefficient;
    for (size_t row = 0; row < step; ++row) heights[row] -= coefficient * matrix.column(order[step])[row];
  }
  return true;
}

size_t JetQrBytes(size_t neighbor_count, int degree) {
  const auto columns = static_cast<size_t>(JetSize(degree)) + 1;
  return (neighbor_count * columns + 2 * columns) * sizeof(double);
}

}  // namespace curvd
