// The flags of `curv estimate` that `curv tiles plan` has too.
#pragma once

#include "CLI/CLI.hpp"
#include "client/cli/files/estimate_files.h"

namespace curv {

// Each adds flags to a command; `flags` must outlive it.
// --estimator, --k, --radius and all others that say how a neighborhood becomes curvature. ApplyScale takes them over.
void AddEstimatorFlags(CLI::App& command, EstimateFlags& flags);
// Throws CLI::ValidationError if one of these flags is given that the estimator of `options` does not read, or where
// `options` ask for normals alone. REQUIRES: ApplyScale and ApplyQuantities have been called.
void CheckEstimatorFlags(const CLI::App& command, const EstimateOptions& options);
// --on-invalid.
void AddInvalidFlag(CLI::App& command, EstimateFlags& flags);

}  // namespace curv
