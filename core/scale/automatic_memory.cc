#include "core/scale/automatic_memory.h"

#include <algorithm>
#include <map>
#include <string_view>
#include <utility>

#include "core/estimators/strategies.h"
#include "core/scale/automatic_options.h"
#include "core/scale/chosen/automatic_scratch.h"
#include "core/scale/detail/near_check.h"
#include "core/scale/errors/error_samples.h"
#include "core/scale/judging/judged_candidates.h"
#include "core/scale/nearest_samples.h"
#include "core/scale/parts/cloud_choice.h"
#include "core/scale/parts/cloud_weights.h"
#include "core/scale/pilot/pilot.h"
#include "core/scale/pilot/pilot_table.h"
#include "core/scale/scale_choice.h"

namespace curvd {
namespace {

EstimatorOptions PilotOptions(const EstimatorOptions& options) {
  EstimatorOptions pilot;
  pilot.neighborhood = NeighborCount{MostSampledCount(options)};
  return pilot;
}

size_t MostParts(const EstimatorOptions& options) { return IsPerPoint(options) ? CloudChoice::kMostParts : 1; }

// Where there are parts, those between are as many as the others.
size_t MostSamples(const EstimatorOptions& options) { return MostParts(options) * Pilot::kMostPoints; }

// Estimates that check the chosen ones for detail and for small bodies in each part, at most.
size_t MostChecks(const EstimatorOptions& options) {
  return IsPerPoint(options) ? (1 + kMostNearChecks) * MostParts(options) : 0;
}

// Chosen estimates share scratch by its type: those of one estimator, but for the linear regression, which is a
// strategy of its own.
size_t MostChosenBytes(const EstimatorOptions& options, size_t point_count) {
  std::map<std::pair<std::string_view, bool>, size_t> of_type;
  for (size_t m = 0; m < kMethodCount; ++m) {
    if (!IsCandidate(options, m)) continue;
    const EstimatorOptions one = OptionsOf(options, m, MostCount(options));
    const bool is_linear = kScaleMethods[m].is_regression() && kScaleMethods[m].degree == 1;
    size_t& most = of_type[{kScaleMethods[m].estimator, is_linear}];
    most = std::max(most, FindStrategy(one.estimator)->scratch_bytes(one, point_count));
  }
  size_t bytes = 0;
  for (const auto& [type, most] : of_type) bytes += most;
  const size_t parts = MostParts(options);
  const size_t estimates = parts * ScaleChoice::kMostChosen + (parts > 1 ? 1 : 0) + MostChecks(options);
  return bytes + estimates * (sizeof(void*) + sizeof(size_t) + sizeof(float));
}

}  // namespace

size_t AutomaticScratchBytes(const EstimatorOptions& options, size_t point_count) {
  const size_t parts = MostParts(options), samples = MostSamples(options);
  return sizeof(AutomaticScratch) - sizeof(PilotScratch) + PilotScratch::MostBytes(PilotOptions(options), point_count) +
         CloudWeights::MostBytes(samples) +
         (options.returns_choice ? NearestSamples::MostBytes(samples) + parts * sizeof(NearestSamples) : 0) +
         MostChosenBytes(options, point_count);
}

// The table, what it is split into parts with, which is as large, and what chooses.
size_t AutomaticSharedBytes(const EstimatorOptions& options, size_t point_count) {
  return std::min(MostSamples(options), point_count) *
         (2 * sizeof(PilotPoint) + JudgingBytesPerSample() + (options.returns_choice ? sizeof(ErrorSample) : 0));
}

}  // namespace curvd
