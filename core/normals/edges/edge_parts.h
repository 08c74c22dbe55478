// Where edges of the surface make the scale small, points away from them get a larger one.
#pragma once

#include "core/normals/chosen_fit.h"
#include "core/normals/sample_table.h"

namespace curvd {

// The same fit; or, if edges are what made its scale small, one of more neighbors with an edge part, and the
// squared_error of the other. REQUIRES: `chosen` was chosen from the table, for that aim.
ChosenFit MindEdges(const SampleTable& table, NormalAim aim, const ChosenFit& chosen);

}  // namespace curvd
