// Avg-hexagram (Lachaud et al. 2023, section 4) in plain scalar doubles, one rotation: what a careful person writes
// down from the paper. Conventions are curvd's, so that the results can be compared point by point.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bench/peers/peers.h"
#include "core/estimators/curvature_field.h"

namespace curvd::bench {

// Curvature at point `query` from its `count` neighbors, itself included. `positions` and `normals` are packed triples.
// The status is kInconsistentNormals, beside values as the paper gives them, where the normals of a sector cancel to
// less than a tenth: there curvd departs from the paper, and the two cannot be compared.
template <typename Scalar>
PointCurvature PlainAvgHexagram(const Scalar* positions, const Scalar* normals, uint32_t query,
                                const uint32_t* neighbors, size_t count, double radius, PeerWork work);

extern template PointCurvature PlainAvgHexagram(const float*, const float*, uint32_t, const uint32_t*, size_t, double,
                                                PeerWork);
extern template PointCurvature PlainAvgHexagram(const double*, const double*, uint32_t, const uint32_t*, size_t, double,
                                                PeerWork);

}  // namespace curvd::bench
