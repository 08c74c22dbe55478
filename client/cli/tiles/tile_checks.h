// What no estimate in tiles can do.
#pragma once

#include "client/cli/normals/normal_flags.h"
#include "client/cli/quantities/quantity_flags.h"

namespace curv {

// These throw CLI::ValidationError naming the flag, and why tiles cannot serve it.
// Normals that follow from the whole cloud.
void CheckTileNormals(const NormalFlags& normals);
// Quantities that follow from a sample of the whole cloud, or take directions.
void CheckTileQuantities(const QuantityFlags& quantities);

}  // namespace curv
