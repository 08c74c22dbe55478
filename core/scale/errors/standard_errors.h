// How sure an automatic estimate is: standard errors from what the sampled points show
// (docs/numerics/standard_errors.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/scale/errors/attenuation.h"
#include "core/scale/errors/error_samples.h"
#include "core/scale/pilot/pilot_table.h"

namespace curvd {

// Of one point: nine in ten of the intervals from H - 1.645 mean to H + 1.645 mean hold the truth, and likewise for k1
// and k2. NaN where nothing can be said.
struct StandardErrors {
  double mean;
  double k1;
  double k2;
};

// Takes the errors at a point from those of the sampled points nearby. Const methods are thread-safe.
class ErrorModel {
 public:
  // Sampled points that the errors at a point are taken from.
  static constexpr size_t kNearest = 24;
  // Fewer of them, unless the cloud has no more, say nothing.
  static constexpr size_t kLeastNearest = 8;

  // Without samples it knows nothing: NaN everywhere.
  explicit ErrorModel(std::vector<ErrorSample> samples = {}, const Attenuation& attenuation = {})
      : samples_(std::move(samples)), attenuation_(attenuation) {}

  // Of a point whose nearest samples those are, and whose principal curvatures are mean - half_difference and mean +
  // half_difference. In units of 1 / the index's length, as those are. REQUIRES: `nearest` are places among the
  // samples, if there are any; at most kNearest.
  StandardErrors At(std::span<const uint32_t> nearest, double mean, double half_difference) const;

  size_t bytes() const { return samples_.capacity() * sizeof(ErrorSample); }

 private:
  std::vector<ErrorSample> samples_;
  Attenuation attenuation_;
};

// Standard deviation of the noise of the normals along each tangent, in radians, as the residuals of fits show it
// beyond what noise in the positions, of that standard deviation in the index's unit, makes of it. Nothing where no
// sampled point has the neighbors for it.
std::optional<double> NormalNoise(PilotPoints table, double position_noise);

}  // namespace curvd
