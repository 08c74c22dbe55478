// The fit that is chosen for the normals of a cloud.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "core/normals/normal_fit.h"

namespace curvd {

// What normals are made for.
enum class NormalAim : uint8_t {
  kNormals,    // they are the result
  kCurvature,  // the result is made of those of whole neighborhoods
};

struct ChosenFit {
  NormalFit fit;
  // Of the positions' noise, in the caller's unit; none where no point of the sample told. Where a part is noisier than
  // others, that of the others.
  std::optional<double> sigma;
  // Of the noisier part, if there is one, and the share of the points that lie in it.
  std::optional<double> noisy_sigma;
  double noisy_share = 0.0;
  // What its normals are expected to err by, squared, in radians: by noise, and by bends with their weight. Infinity
  // where the sample tells nothing.
  double squared_error = std::numeric_limits<double>::infinity();
};

}  // namespace curvd
