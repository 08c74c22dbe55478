// The bias of an estimate, told by how much it changes from scale to scale (docs/numerics/automatic_choice.md, "Bias
// that grows").
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "core/estimators/scale_ladder.h"

namespace curvd {

// The mean, over the sampled points, of the products of what both halves of a neighborhood change from a scale to
// another: noise adds nothing to it, detail that is smoothed away its square.
struct CommonChange {
  double mean, standard_error;
  double mean_square;  // of the products
};

// Of one method. What halves show beside smaller neighborhoods is less than the bias, since these have lost detail as
// well. How much more it is, the growth of the changes tells: the less they grow, the more was lost before.
class GrowingBias {
 public:
  // Nothing tells any.
  GrowingBias() = default;
  // `changes`: from each rung to that `step` rungs on, where it is known. In one unit, as all that follows.
  GrowingBias(const std::array<std::optional<CommonChange>, kRungCount>& changes, size_t step);

  // 0: nothing tells it.
  double At(size_t rung) const { return bias_[rung]; }
  // How many times larger it is than the change from this rung; 0: nothing tells it.
  double PerChange(size_t rung) const { return per_change_[rung]; }

 private:
  std::array<double, kRungCount> bias_{}, per_change_{};
};

}  // namespace curvd
