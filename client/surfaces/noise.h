// Gaussian perturbation of samples, as in the accuracy tests of the paper.
#pragma once

#include <cstdint>
#include <vector>

#include "client/surfaces/vec3.h"

namespace curv {

// Adds to each coordinate a Gaussian of standard deviation `sigma`, in the positions' length unit. The same seed gives
// the same noise; position and normal noise of one seed are independent.
void AddPositionNoise(double sigma, uint64_t seed, std::vector<Vec3>& positions);

// Adds to each component of the unit normals a Gaussian of standard deviation `sigma`, then normalizes.
void AddNormalNoise(double sigma, uint64_t seed, std::vector<Vec3>& normals);

}  // namespace curv
