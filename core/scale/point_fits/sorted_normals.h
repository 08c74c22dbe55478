// The normals of collected neighbors in a fixed order.
#pragma once

#include "core/scale/pilot/pilot_scratch.h"

namespace curvd {

// Lists the neighbors that CollectNeighbors has found in s.normals, by their distances, then by their ids: none beyond
// `most`, in the index's unit, and no copies.
void SortNormals(float most, PilotScratch& s);

}  // namespace curvd
