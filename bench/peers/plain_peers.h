// The other estimators in plain scalar doubles: what a careful person writes down from the papers. One thread, the
// calling one. Conventions are curvd's. Where they leave freedom, the choice is the authors' or Ponca's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/estimators/curvature_field.h"

namespace curvd::bench {

// Packed triples.
struct PeerCloud {
  std::span<const double> positions;
  std::span<const double> normals;

  size_t size() const { return positions.size() / 3; }
};

// The K nearest points of the first `size()` points of a cloud, each list sorted by distance.
struct PeerNeighbors {
  size_t k = 0;
  std::vector<uint32_t> indices;  // K a point
  std::vector<double> radii;      // distance of the K-th

  size_t size() const { return radii.size(); }
  std::span<const uint32_t> of(size_t i) const { return std::span(indices).subspan(i * k, k); }
};

// The way most people do it: nanoflann, leaves of 10, neighbors sorted. For the first `points` points of `cloud`.
PeerNeighbors FindPeerNeighbors(const PeerCloud& cloud, size_t k, size_t points);

// All of these write out[i] for each point that has neighbors.

// The paper's avg-hexagram (plain_estimator.h).
void RunPlainAvgHexagram(const PeerCloud& cloud, const PeerNeighbors& neighbors, PointCurvature* out);

// As the authors' code: targets at the mean neighbor distance, each corner the nearest of the K neighbors.
void RunPlainHexagram(const PeerCloud& cloud, const PeerNeighbors& neighbors, PointCurvature* out);

// `triangles` triangles with distinct corners drawn from the neighbors.
void RunPlainUniform(const PeerCloud& cloud, const PeerNeighbors& neighbors, size_t triangles, PointCurvature* out);

// Disjoint triangles over a shuffle of the neighbors, at most `triangles`.
void RunPlainIndependent(const PeerCloud& cloud, const PeerNeighbors& neighbors, size_t triangles, PointCurvature* out);

// The algebraic shape operator (Lejemble et al. 2021), as Ponca computes it: oriented sphere fit with the weights
// (1 - (d / r)^2)^2, r the K-th distance, and the Hessian of the field that the spheres define together.
void RunPlainShapeOperator(const PeerCloud& cloud, const PeerNeighbors& neighbors, PointCurvature* out);

// CNC-Delaunay: the local Delaunay umbrella of each point over its `umbrella_size` nearest, itself included (Sharp,
// Crane 2020), then all umbrella triangles within a neighborhood. The umbrellas' own search is part of it.
void RunPlainUmbrellas(const PeerCloud& cloud, const PeerNeighbors& neighbors, size_t umbrella_size,
                       PointCurvature* out);

// CGAL's jet fitting, signs turned to curvd's.
void RunCgalJet(const PeerCloud& cloud, const PeerNeighbors& neighbors, size_t degree, PointCurvature* out);

}  // namespace curvd::bench
