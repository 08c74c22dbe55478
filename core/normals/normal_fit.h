// Which fit to the neighbors of each point makes normals: what is asked for, as plain values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>

#include "core/base/halves.h"
#include "core/estimators/options.h"
#include "core/index/spatial_index.h"
#include "core/normals/normal_options.h"

namespace curvd {

// How points are fitted where positions are much noisier than elsewhere.
struct NoisyPart {
  NormalMethod method = NormalMethod::kJet2;
  NeighborCount neighborhood{};
  bool shares = false;         // as in NormalFit
  bool crosses_lines = false;  // as in NormalFit
  // Which groups these are: those whose points, one of each leaf, lie so far from quadrics through so many neighbors in
  // the median, squared, in the index's unit.
  uint32_t probe_count = 0;
  double least_variance = 0.0;
  double quiet_variance = 0.0;  // the same of the other groups, in the median
  // By their own fits, neighborhoods of these reach into noise if they lie this many times as far away, squared, as by
  // the quadrics, or as quiet_variance says where that is more.
  static constexpr double kMixedRatio = 2.5;
};

// How points are fitted beside edges of the surface: by the method of the other points.
struct EdgePart {
  NeighborCount neighborhood{};  // fewer than elsewhere
  // Of the positions' noise, in the index's unit.
  double variance = 0.0;

  // A neighborhood reaches across an edge if its fit leaves more of the heights than so many times what noise leaves.
  // The fit has so many neighbors more than coefficients.
  static double MostOfNoise(double freedom);
};

// One way to make normals, of those that NormalOptions may ask for.
struct NormalFit {
  // Fewer neighbors are not shared (see `shares`): the points of a leaf would be too far from its mean beside their
  // radius.
  static constexpr uint32_t kLeastShared = size_t{16} * SpatialIndex::kLeafSize;

  NormalMethod method = NormalMethod::kJet2;
  std::variant<NeighborCount, NeighborRadius> neighborhood{};
  uint32_t max_neighbor_count = 10'000;
  // Whether neighborhoods hold both sheets of a thin part. At its rim, no fit to both tells where the rim looks:
  // normals there turn from one sheet's to the other's.
  bool two_sheets = false;
  // Whether the points of a leaf of the index share one polynomial, fitted to the neighbors of their mean and read
  // where each of them lies. Points that are far from the mean, and those of leaves without a fit, have their own.
  // REQUIRES: by count; the degree is 2 or more; not two_sheets.
  bool shares = false;
  // Whether points lie on lines that are farther from each other than the points of one. Where neighborhoods cross too
  // few, noise decides a polynomial of the degree; such points get one of a lower degree. Elsewhere, as in narrow
  // strips, one that noise decides in part is better.
  bool crosses_lines = false;
  // If set, points of groups that are noisier than others are fitted by this. Those of other groups whose neighborhoods
  // reach into noise get half of the neighbors, and again, until they do not. REQUIRES: by count; not two_sheets.
  std::optional<NoisyPart> noisy_part{};
  // If set, points whose neighborhoods reach across an edge get half of the neighbors, and again, until these lie on
  // one side, or until they are no more than those of the edge part, which fits the points that are left. REQUIRES: by
  // count, of which the edge part has at most half; neither shares, nor two_sheets, nor noisy_part.
  std::optional<EdgePart> edge_part{};
  // Of which half of the cloud points are fitted, and are the neighbors that they are fitted to, which still lie among
  // as many of both halves. DEFAULT: of both. REQUIRES: not two_sheets.
  std::optional<Half> half{};

  // The options of an estimate that has the same neighborhoods, and needs the same scratch.
  EstimatorOptions ToEstimatorOptions() const;
  // Those of an estimate that takes about as long for a point as the fit.
  EstimatorOptions OptionsForOnePoint() const;
};

// That of the points of the noisy part, as a fit of its own. REQUIRES: whole.noisy_part is set.
NormalFit FitOfNoisyPart(const NormalFit& whole);

// The plane through so many neighbors, the point itself included, by their principal axes.
NormalFit PlaneFit(size_t neighbor_count);

}  // namespace curvd
