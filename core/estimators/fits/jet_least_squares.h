// Jets whose least squares problem is nearly singular.
#pragma once

#include <cstddef>

#include "core/base/scratch_array.h"
#include "core/estimators/fits/jet_systems.h"
#include "core/estimators/neighbors/neighbors.h"

namespace curvd {

// Solves the least squares problem of point i of a group, whose frame is in `jets`, by a QR factorization with column
// pivoting; writes jets.coefficients[...][i]. `unit` takes the neighbors' offsets to units of rho. Returns false, and
// writes nothing, if the problem is singular to the rounding of the offsets: a monomial is a combination of others on
// the neighbors to 1e-6 of the largest. `room` is scratch. Throws std::bad_alloc.
// REQUIRES: at least JetSize(degree) neighbors.
bool SolveJetByQr(const NeighborArrays& neighbors, size_t i, double unit, int degree, ScratchArray<double>& room,
                  JetSystems& jets);

// Bytes that `room` holds at most for so many neighbors, and what SolveJetByQr allocates beside it while it runs.
size_t JetQrBytes(size_t neighbor_count, int degree);

}  // namespace curvd
