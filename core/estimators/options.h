// How curvature is estimated: plain values with defaults, checked by Validate. Ranges stand in
// core/estimators/option_specs.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <variant>

#include "absl/status/status.h"

namespace curvd {

// The K nearest points, the point itself included; equal distances go to the lower index.
struct NeighborCount {
  uint32_t count = 50;
};

// All points at distance <= radius (closed ball), in the cloud's length unit.
struct NeighborRadius {
  double radius = 0.0;
};

// Chosen from a sample of the points: by which estimators, and from how many nearest points, each point is estimated;
// the estimates of the best are averaged (core/scale/scale_choice.h).
struct AutomaticScale {
  // No neighborhood has fewer points, or more, as far as a rung of core/estimators/scale_ladder.h lies between them.
  uint32_t least_count = 16;   // DEFAULT: 16; in [kLeastAutomaticCount, most_count]
  uint32_t most_count = 2048;  // DEFAULT: 2,048; at most kMostAutomaticCount
  // No estimate looks farther than this, in the cloud's length unit; points that cannot be estimated within it have
  // PointStatus::kTooFewNeighbors. DEFAULT (0): any distance.
  double max_radius = 0.0;
  // The same weights at every point, instead of those of the points nearby. DEFAULT: false.
  bool per_cloud = false;
};
inline constexpr uint32_t kLeastAutomaticCount = 16, kMostAutomaticCount = 2048;
// The name in EstimatorOptions::estimator that leaves the choice of the estimator open.
inline constexpr std::string_view kAutomaticEstimator = "auto";

// What is done where normals point to opposite sides of one surface.
enum class OpposedNormalsPolicy : uint8_t {
  kMark,    // points whose neighborhoods reach across such a seam get PointStatus::kOpposedNormals
  kReject,  // the estimate fails
};

inline constexpr uint32_t kMinNeighborCount = 4;
inline constexpr uint32_t kMaxTriangleCount = 10'000;
inline constexpr uint32_t kMaxRotations = 4;
inline constexpr uint32_t kMinJetDegree = 2;
inline constexpr uint32_t kMaxJetDegree = 4;
inline constexpr uint32_t kMinRegressionDegree = 1;
inline constexpr uint32_t kMaxRegressionDegree = 3;

// How many numbers of neighbors one estimate takes at most.
inline constexpr size_t kMaxScales = 16;

// Numbers of neighbors beside the largest one.
struct SmallerCounts {
  std::array<uint32_t, kMaxScales - 1> counts{};
  size_t size = 0;

  std::span<const uint32_t> span() const { return {counts.data(), size}; }
};

struct EstimatorOptions {
  // The name of a strategy (core/estimators/strategies.h); outlives the options. DEFAULT: avg-hexagram.
  std::string_view estimator = "avg-hexagram";
  std::variant<NeighborCount, NeighborRadius, AutomaticScale> neighborhood{};  // DEFAULT: NeighborCount{50}
  uint32_t triangle_count = 100;  // DEFAULT: 100; uniform and independent only
  uint64_t seed = 0;              // DEFAULT: 0; random strategies only
  // Hexagrams that avg-hexagram averages over, turned by 60 / rotation_count degrees; 1 is the paper's estimator.
  uint32_t rotation_count = 2;  // DEFAULT: 2; in [1, kMaxRotations]
  // Of the polynomial that jet fitting fits; a fit needs (degree + 1) (degree + 2) / 2 neighbors. 4 is the more
  // accurate where positions are exact, 2 where they are noisy.
  uint32_t jet_degree = 2;  // DEFAULT: 2; in [kMinJetDegree, kMaxJetDegree]
  // Of the polynomials that normal-regression fits to the normals. 3 follows the surface farther, 2 takes more of the
  // noise away in a neighborhood of one size; 1 is fitted over space, and right for spheres, cylinders and planes
  // however far around them a neighborhood reaches.
  uint32_t regression_degree = 3;      // DEFAULT: 3; in [kMinRegressionDegree, kMaxRegressionDegree]
  double average_normal_weight = 0.5;  // DEFAULT: 0.5; in [0, 1]
  // Delaunay only: all triangles count alike, as in the paper, instead of less the farther they lie from the point.
  bool even_weights = false;  // DEFAULT: false
  // aso only: the curvature of the surface at the place nearest to the point, in place of that of the level of the
  // fitted field that the point lies on, which noise in its own position moves.
  bool project = false;  // DEFAULT: false
  // Most points that one neighborhood may hold: bounds NeighborCount, and the size that a radius neighborhood may reach
  // before the whole estimate fails with RESOURCE_EXHAUSTED.
  uint32_t max_neighbor_count = 10'000;                                // DEFAULT: 10,000
  OpposedNormalsPolicy opposed_normals = OpposedNormalsPolicy::kMark;  // DEFAULT: kMark
  // Hand out how each point's estimate was chosen, and how sure it is (core/estimators/point_choice.h). Where neither
  // estimator nor scale is left open, the cloud is sampled all the same, for what the choice knows: its estimators, and
  // neighbor counts in [kLeastAutomaticCount, kMostAutomaticCount].
  bool returns_choice = false;  // DEFAULT: false

  // Each point is estimated from so many neighbors as well, which are among those that are found for `neighborhood`:
  // that one is a NeighborCount, and these are smaller, in descending order. Only of strategies that take several
  // scales (Strategy::start_scales). DEFAULT: none.
  SmallerCounts smaller_counts{};

  // Scales at which each point is estimated: that of `neighborhood`, then those of smaller_counts.
  size_t scale_count() const { return 1 + smaller_counts.size; }
  // The options of the estimate at one scale alone. REQUIRES: scale < scale_count().
  EstimatorOptions AtScale(size_t scale) const;
  // The options without the first `scale` scales. REQUIRES: as above.
  EstimatorOptions FromScale(size_t scale) const;

  // Whether the estimator or the scale is left open.
  bool is_automatic() const {
    return estimator == kAutomaticEstimator || std::holds_alternative<AutomaticScale>(neighborhood);
  }

  // INVALID_ARGUMENT naming field, value and limit if a field is out of its range, or if an automatic scale, or how
  // sure an estimate is, is asked of an estimator or a neighborhood that the choice does not know, or several scales of
  // a strategy that takes one.
  absl::Status Validate() const;
};

}  // namespace curvd
