// An estimate that tells whether those which are chosen for a cloud smooth detail away at a point.
#pragma once

#include <cstddef>
#include <optional>

#include "core/estimators/scale_ladder.h"
#include "core/scale/pilot/pilot_table.h"
#include "core/scale/scale_choice.h"

namespace curvd {

// It looks less far than the chosen ones, and has more noise: of this standard deviation in the mean curvature, in 1 /
// the index's length.
struct DetailCheck {
  ScaleCandidate candidate;
  double noise;
};

// A regression of normals of degree 3 with a few times the error of the best. None where that was not judged, where
// noise leaves no room for smaller neighborhoods, where jets of exact positions see detail better, or where it is not
// independent noise of the normals that decides. `choice` is made of the samples. Thread-safe.
std::optional<DetailCheck> FindDetailCheck(PilotPoints samples, const ScaleChoice& choice);

// Whether independent noise of the normals decides what the regression of degree 3 errs by at a rung. Thread-safe.
bool DecidesNoise(PilotPoints samples, const ScaleChoice& choice, size_t rung);

// The largest rung that counts much among the chosen. Thread-safe.
size_t FarthestThatCounts(const ScaleChoice& choice);

}  // namespace curvd
