// The phases that make a SpatialIndex of a cloud.
#pragma once

#include <memory>
#include <string_view>

#include "core/base/phase.h"
#include "core/index/index_builder.h"

namespace curvd {

// The name of all phases below.
inline constexpr std::string_view kIndexPhase = "index";

// Runs the next one of the builder's phases before the tree (IndexBuilder::RunBlock); there may be none left.
// REQUIRES: `builder` outlives the phase, and Start was called by the time that the phase begins.
std::unique_ptr<Phase> MakeCollectPhase(IndexBuilder& builder);

// Builds the tree. Its blocks are nodes: whoever splits one adds its two halves, so that no thread waits for the end of
// a level. REQUIRES: as above, and two phases of MakeCollectPhase came before.
std::unique_ptr<Phase> MakeTreePhase(IndexBuilder& builder);

}  // namespace curvd
