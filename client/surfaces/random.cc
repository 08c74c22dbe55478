#include "client/surfaces/random.h"

#include <cmath>
#include <numbers>

namespace curv {

double CounterRandom::Gaussian(uint64_t index) const {
  // Box and Muller. 1 - u lies in (0, 1], so that the logarithm is finite.
  const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform(2 * index)));
  return radius * std::cos(2.0 * std::numbers::pi * Uniform(2 * index + 1));
}

}  // namespace curv
