// An estimate of few neighbors that tells whether those which are chosen for a cloud miss a small body at a point.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/estimators/scale_ladder.h"
#include "core/scale/pilot/pilot_table.h"
#include "core/scale/scale_choice.h"

namespace curvd {

// It counts nowhere. Lengths are in the index's unit.
struct NearCheck {
  ScaleCandidate candidate;
  double most_difference;  // from the average of what is chosen, where nothing is missed
  bool is_noise;           // independent noise of normals makes the difference
};

inline constexpr size_t kMostNearChecks = 2;

// By 32 and by 128 neighbors, each of the method that differs the least from the average of what is chosen, at four in
// five of the samples. None where that looks hardly farther, or samples are few. `choice` is made of them; no check has
// fewer neighbors than `least_count`. Unless the noise of the normals that checks are made by is known, none
// `is_noise`. Thread-safe.
std::vector<NearCheck> FindNearChecks(PilotPoints samples, const ScaleChoice& choice, uint32_t least_count,
                                      bool is_noise_known = true);

}  // namespace curvd
