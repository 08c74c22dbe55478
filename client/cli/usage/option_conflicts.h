// Options that no server takes together.
#pragma once

#include <string>

#include "client/cli/normals/normal_flags.h"
#include "client/cli/quantities/quantity_flags.h"
#include "client/curvature_client.h"

namespace curv {

// Throws CLI::ValidationError, in terms of flags, if any server would refuse such options, whatever the cloud.
// REQUIRES: ApplyScale and ApplyQuantities, of these quantities, have been called.
void CheckConflicts(const EstimateOptions& options, const QuantityFlags& quantities);

// The same of how normals are made, by the flags --PREFIXk and --PREFIXmethod.
void CheckNormalCount(const std::string& prefix, const NormalFlags& flags);

}  // namespace curv
