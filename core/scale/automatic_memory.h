// How much memory the automatic choice takes, at most.
#pragma once

#include <cstddef>

#include "core/estimators/options.h"

namespace curvd {

// The scratch of one worker, and what the run keeps for all of them, in bytes; see Strategy::scratch_bytes and
// Strategy::shared_bytes. REQUIRES: options.is_automatic() or options.returns_choice.
size_t AutomaticScratchBytes(const EstimatorOptions& options, size_t point_count);
size_t AutomaticSharedBytes(const EstimatorOptions& options, size_t point_count);

}  // namespace curvd
