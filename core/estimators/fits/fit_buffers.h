// What the kernels that fit a surface to each neighborhood keep between their steps, in doubles. Internal to
// core/estimators/group_estimator.cc and core/kernels.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/scratch_array.h"
#include "core/estimators/options.h"
#include "core/index/spatial_index.h"

namespace curvd {

// A quantity of each point of a group.
using GroupDoubles = double[SpatialIndex::kGroupPoints];

struct alignas(64) GroupDoubleVectors {
  GroupDoubles x, y, z;

  void Set(size_t i, const double* v) {
    x[i] = v[0];
    y[i] = v[1];
    z[i] = v[2];
  }
};

// Shape operator of each point's surface: curvature in units of 1 / rho.
struct alignas(64) GroupShapes {
  GroupDoubles mean, gaussian, half_difference;
  GroupDoubleVectors d1, d2;
};

// Coefficients of a polynomial of two variables and the given degree; x^i y^j has index JetIndex(i, j).
constexpr int JetSize(int degree) { return (degree + 1) * (degree + 2) / 2; }
constexpr int JetIndex(int i, int j) { return (i + j) * (i + j + 1) / 2 + j; }

inline constexpr int kMaxJetSize = JetSize(kMaxJetDegree);
inline constexpr int kMaxJetMoments = JetSize(2 * kMaxJetDegree);

// The least squares problem of each point's jet, in units of rho and in the frame (u, v, axis) around the point.
struct alignas(64) JetSystems {
  GroupDoubleVectors u, v, axis;
  GroupDoubles moments[kMaxJetMoments];    // sums of x^i y^j, and
  GroupDoubles heights[kMaxJetSize];       // of z x^i y^j, by JetIndex
  GroupDoubles coefficients[kMaxJetSize];  // the solution
  GroupDoubles least_pivot;                // of the normal equations, relative to the number of neighbors
};

// Weighted sums over the neighbors of each point, for the algebraic sphere and its derivatives.
struct alignas(64) SphereSums {
  static constexpr int kMoments = 9;  // of 1, q, n, q n, q q

  GroupDoubles weighted[kMoments];     // sums of w times each
  GroupDoubles gradient[3][kMoments];  // of the derivatives of w times each
  GroupDoubles influence_hessian[6];   // of the second derivatives of w times d potential / d w: xx xy xz yy yz zz
};

struct FitBuffers {
  // Columns of one number a neighbor, padded with zeros to a whole vector.
  ScratchArray<double> columns;
  size_t column_stride = 0;

  double* column(size_t c) { return columns.data() + c * column_stride; }
  // Room for `count` columns of `size` numbers.
  void ReserveColumns(size_t count, size_t size) {
    constexpr size_t kLongestVector = 8;
    column_stride = (size + kLongestVector - 1) / kLongestVector * kLongestVector;
    columns.Reserve(count * column_stride);
  }

  JetSystems jets{};
  SphereSums spheres{};
  GroupShapes shapes{};
};

}  // namespace curvd
