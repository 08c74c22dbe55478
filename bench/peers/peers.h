// The same work with nanoflann and plain code: what curvd is compared with. One thread, the calling one.
#pragma once

#include <cstddef>
#include <span>

#include "core/estimators/curvature_field.h"

namespace curvd::bench {

// What a peer does with each neighborhood. Only `radius` is written for kSearch.
enum class PeerWork {
  kSearch,
  kPlainEstimate,  // avg-hexagram as the paper words it: the nearest of six targets
  kTunedEstimate,  // the same with three sign tests in place of six distances
};

// CPU seconds.
struct PeerCost {
  double build = 0.0;  // of the tree, sorting included
  double query = 0.0;  // search, estimate, and writing the results
};

// The way most people do it: nanoflann, double, leaves of 10, queries in input order, neighbors sorted.
// `out` has one element a point, in the order of the points. Of the queries one run in `one_in` is answered
// (bench/peers/sampled_queries.h): the cost is that of all, and `out` stays as it is for the others.
// REQUIRES: at least `k` points.
PeerCost RunCommonWay(std::span<const double> positions, std::span<const double> normals, size_t k, PeerWork work,
                      PointCurvature* out, size_t one_in = 1);

// The fastest that was found of what can be had: nanoflann, float, leaves of 32, a binary heap as result set, points
// and queries in Morton order. Otherwise as RunCommonWay.
PeerCost RunStrongestPeer(std::span<const float> positions, std::span<const float> normals, size_t k, PeerWork work,
                          PointCurvature* out, size_t one_in = 1);

}  // namespace curvd::bench
