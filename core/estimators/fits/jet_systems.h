// The least squares problems of the jets of a group.
#pragma once

#include "core/estimators/fits/group_shapes.h"
#include "core/estimators/options.h"

namespace curvd {

// Coefficients of a polynomial of two variables and the given degree; x^i y^j has index JetIndex(i, j).
constexpr int JetSize(int degree) { return (degree + 1) * (degree + 2) / 2; }
constexpr int JetIndex(int i, int j) { return (i + j) * (i + j + 1) / 2 + j; }

// Columns that setting up one problem uses: 1, x .. x^2d, y .. y^2d, z, z x .. z x^d for degree d.
constexpr size_t JetColumnCount(int degree) { return 5 * static_cast<size_t>(degree) + 2; }

// Neighbors whose columns are filled at a time: those of degree 6 take 32 kB, which stay in the first cache.
inline constexpr size_t kMostInJetColumns = 128;

// The highest degree that is fitted: of what the automatic choice knows, which is more than callers may ask for.
inline constexpr int kMaxFittedDegree = 6;
inline constexpr int kMaxJetSize = JetSize(kMaxFittedDegree);
inline constexpr int kMaxJetMoments = JetSize(2 * kMaxFittedDegree);
static_assert(kMaxJetDegree <= kMaxFittedDegree);

// The least squares problem of each point's jet, in units of rho and in the frame (u, v, axis) around the point.
struct alignas(64) JetSystems {
  GroupDoubleVectors u, v, axis;
  GroupDoubles moments[kMaxJetMoments];    // sums of x^i y^j, and
  GroupDoubles heights[kMaxJetSize];       // of z x^i y^j, by JetIndex
  GroupDoubles squared_heights;            // sum of z^2
  GroupDoubles coefficients[kMaxJetSize];  // the solution
  GroupDoubles least_pivot;                // of the normal equations, relative to the number of neighbors
};

}  // namespace curvd
