// Chooses the lattice on which coordinates lie in a LAS file.
#pragma once

#include <optional>
#include <string_view>

#include "absl/status/statusor.h"
#include "client/io/las/las_frame.h"
#include "client/io/point_table.h"

namespace curv {

// Returns a lattice for the coordinates of one axis: `preferred` if they all lie on it to the last bit; else, if there
// is one, the coarsest of 1, 0.1, ... 1e-12 that gives every coordinate back in the column's type; else one that is as
// fine as 32 bits allow, so that a coordinate moves by at most the column's extent / 2^31.
// INVALID_ARGUMENT naming the point if a coordinate is not finite, or the extent is outside the range of double.
absl::StatusOr<LasAxis> ChooseAxis(const Column& coordinates, const std::optional<LasAxis>& preferred);

// Returns the number of the lattice's step that is nearest to `value`. REQUIRES: ChooseAxis returned `axis` for it.
int32_t StepOf(const LasAxis& axis, double value);

}  // namespace curv
