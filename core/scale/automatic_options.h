// What an automatic estimate is asked for, and what follows from that.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/estimators/options.h"
#include "core/estimators/scale_ladder.h"
#include "core/index/spatial_index.h"
#include "core/scale/scale_choice.h"

namespace curvd {

// The bounds of the scale that is left open; the widest where it is not.
AutomaticScale ScaleOf(const EstimatorOptions& options);
// The count that every estimate has, where only the estimator is left open, or nothing is, or the bounds of the scale
// hold no rung: the one of these bounds that is nearest to one. REQUIRES: the options are valid.
std::optional<uint32_t> FixedCount(const EstimatorOptions& options);
// The same options, but that no neighborhood has more points than the cloud has. REQUIRES: LeastPoints are in the
// cloud.
EstimatorOptions WithinCloud(EstimatorOptions options, size_t point_count);
// The rung that is nearest to a count, on the scale of its ratios.
size_t RungNear(uint32_t count);
// Whether the options leave the choice of this one of kScaleMethods.
bool IsCandidate(const EstimatorOptions& options, size_t method);
// The options of the estimate that a method makes from so many neighbors.
EstimatorOptions OptionsOf(const EstimatorOptions& options, size_t method, uint32_t count);
// The largest neighborhood that may be chosen, and the largest that is sampled: rungs above that one are what it is
// compared with.
uint32_t MostCount(const EstimatorOptions& options);
uint32_t MostSampledCount(const EstimatorOptions& options);
ScaleBounds BoundsOf(const EstimatorOptions& options, const SpatialIndex& index);
// Where the estimator or the scale is fixed, points beside edges are estimated by it, too.
bool MindsEdges(const EstimatorOptions& options);
// Whether points may be estimated each in its own way: unless all are to have the same weights.
bool IsPerPoint(const EstimatorOptions& options);
// Whether a point may have a fit of its own, of as many neighbors as suit it: where the count is fixed, it may not.
bool MayHaveOwnFits(const EstimatorOptions& options);
// How the noise of estimates from a fixed count compares with that of the nearest rung.
double VarianceFactor(const EstimatorOptions& options, const ScaleCandidate& candidate);

}  // namespace curvd
