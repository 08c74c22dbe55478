// A server's words for options in those of the command line.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace curv {

// Returns `status` with the flags of curv in place of the contract's fields that a server's message names, as --k in
// place of header.options.neighbor_count. Of how normals are made, flags are called --PREFIXk and --PREFIXradius.
absl::Status InFlags(const absl::Status& status, const std::string& normal_prefix);

}  // namespace curv
