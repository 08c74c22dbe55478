// The part of a larger cloud that a header announces.
#pragma once

#include <optional>

#include "absl/status/status.h"
#include "core/cloud/lattice.h"
#include "curvature/v1/curvature.pb.h"

namespace curvd {

// What comes with the points of a call because they are a part of a larger cloud, and where they are put.
struct CloudPart {
  bool has_ids = false;
  bool has_roles = false;
  std::optional<Lattice> lattice;
};

// Reads `proto` into `part`. INVALID_ARGUMENT, with its ErrorDetail, if the lattice is none.
absl::Status ReadPart(const curvature::v1::CloudPart& proto, CloudPart& part);

// The opposite.
void WritePart(const CloudPart& part, curvature::v1::CloudPart& proto);

}  // namespace curvd
