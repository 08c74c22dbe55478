// Which candidate is the best for a part of a sample, by what noise and bends of the surface do to its normals.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/normals/chosen_fit.h"
#include "core/normals/normal_fit.h"
#include "core/normals/normal_options.h"
#include "core/normals/sample_view.h"

namespace curvd {

// The cloud, or a part that gets a scale of its own, has at least so many points for each neighbor of a fit.
inline constexpr size_t kLeastPointsPerNeighbor = 3;
// Errors below this are all good enough: squared radians.
inline constexpr double kNegligibleError = 1e-10;

// All of the part that the view shows. `sigma` is that of SigmaOf (core/normals/sample_noise.h).

// Which candidates a choice can be made of, in their order.
std::vector<bool> UsableCandidates(const SampleView& view, double sigma);

// The squared error of a candidate's normals that noise makes; infinity where it fits no point.
double NoiseOf(const SampleView& view, size_t candidate, double sigma);

// The squared error that noise makes of normals of any fit, as the nearest candidate shows it; none where no point of
// the sample told, or no candidate is of the degree.
std::optional<double> NoiseOfFit(const SampleView& view, NormalMethod method, uint32_t neighbor_count);

// The squared error of a candidate's normals: by noise, and by bends with the weight that the aim has for them. Bends
// show between candidates that are usable, as UsableCandidates has it.
double ErrorOf(const SampleView& view, NormalAim aim, size_t candidate, double sigma, const std::vector<bool>& usable);

// The candidate of nearly the least error that costs least; `fallback` where no point of the sample told. Limits are
// those of `fallback`.
ChosenFit ChooseOne(const SampleView& view, NormalAim aim, const NormalFit& fallback);

}  // namespace curvd
