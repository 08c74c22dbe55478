// How curvature is estimated: plain values with defaults, checked by Validate.
#pragma once

#include <cstdint>
#include <variant>

#include "absl/status/status.h"

namespace curvd {

// How a neighborhood becomes curvature. All but the last two make triangles of it and measure those (Lachaud et al.,
// SGP 2023, section 4).
enum class EstimatorKind : uint8_t {
  kAvgHexagram,  // two triangles over six sector averages
  kHexagram,     // two triangles over the points nearest to six corners
  kUniform,      // triangle_count triangles, corners drawn uniformly
  kIndependent,  // disjoint triangles from one shuffle, at most K / 3
  kDelaunay,     // the triangles of local Delaunay umbrellas (Sharp, Crane 2020) with all corners in the neighborhood
  kJetFitting,   // a polynomial height function over the tangent plane (Cazals, Pouget 2005)
  kAlgebraicShapeOperator,  // an algebraic sphere, differentiated (Lejemble, Coeurjolly, Barthe, Mellado 2021)
};

// Whether it fits a surface to the neighborhood instead of measuring triangles.
constexpr bool FitsSurface(EstimatorKind kind) { return kind >= EstimatorKind::kJetFitting; }

// The K nearest points, the point itself included; equal distances go to the lower index.
struct NeighborCount {
  uint32_t count = 50;
};

// All points at distance <= radius (closed ball), in the cloud's length unit.
struct NeighborRadius {
  double radius = 0.0;
};

inline constexpr uint32_t kMinNeighborCount = 4;
inline constexpr uint32_t kMaxTriangleCount = 10'000;
inline constexpr uint32_t kMaxRotations = 4;
inline constexpr uint32_t kMinJetDegree = 2;
inline constexpr uint32_t kMaxJetDegree = 4;

struct EstimatorOptions {
  EstimatorKind estimator = EstimatorKind::kAvgHexagram;       // DEFAULT: kAvgHexagram
  std::variant<NeighborCount, NeighborRadius> neighborhood{};  // DEFAULT: NeighborCount{50}
  uint32_t triangle_count = 100;                               // DEFAULT: 100; uniform and independent only
  uint64_t seed = 0;                                           // DEFAULT: 0; random strategies only
  // Hexagrams that avg-hexagram averages over, turned by 60 / rotation_count degrees; 1 is the paper's estimator.
  uint32_t rotation_count = 2;  // DEFAULT: 2; in [1, kMaxRotations]
  // Of the polynomial that jet fitting fits; a fit needs (degree + 1) (degree + 2) / 2 neighbors. 4 is the more
  // accurate where positions are exact, 2 where they are noisy.
  uint32_t jet_degree = 2;             // DEFAULT: 2; in [kMinJetDegree, kMaxJetDegree]
  double average_normal_weight = 0.5;  // DEFAULT: 0.5; in [0, 1]
  // Delaunay only: all triangles count alike, as in the paper, instead of less the farther they lie from the point.
  bool even_weights = false;  // DEFAULT: false
  // Most points that one neighborhood may hold: bounds NeighborCount, and the size that a radius neighborhood may reach
  // before the whole estimate fails with RESOURCE_EXHAUSTED.
  uint32_t max_neighbor_count = 10'000;  // DEFAULT: 10,000

  // INVALID_ARGUMENT naming field, value and limit if a field is out of its range.
  absl::Status Validate() const;
};

}  // namespace curvd
