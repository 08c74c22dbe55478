// What a sample tells of the noise of the positions, and of candidates that noise decides.
#pragma once

#include <cstddef>
#include <optional>

#include "core/normals/sample_view.h"

namespace curvd {

// All of the part that the view shows. Sigma is the standard deviation of the noise, in the index's unit.

// What the residuals show; none where no point is fitted, or there is no candidate.
std::optional<double> SigmaOf(const SampleView& view);

// Whether the neighborhoods are so much larger than the noise, and than the lattice on which positions may lie, that a
// fit finds the surface in it.
bool IsLargeEnough(const SampleView& view, size_t candidate, double sigma);

// Whether all fits are determined by where their neighbors lie beyond doubt, but for a few.
bool IsMostlyDetermined(const SampleView& view, size_t candidate);

// Whether the noise decides too many fits, but not at a larger scale of the method: where there are lines. And whether
// that is so at any scale.
bool CrossesTooFew(const SampleView& view, size_t candidate, double sigma);
bool SeesLines(const SampleView& view, double sigma);

}  // namespace curvd
