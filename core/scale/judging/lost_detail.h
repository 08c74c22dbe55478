// Short waves all over a surface that larger neighborhoods lose, as the heights of their points show them
// (docs/numerics/automatic_choice.md, "Short waves").
#pragma once

#include <array>
#include <cstddef>

#include "core/estimators/scale_ladder.h"
#include "core/scale/pilot/pilot_table.h"

namespace curvd {

// Waves that even the smallest halves of neighborhoods have lost, all larger ones agree about: neither halves nor
// differences between scales show them. But what jets leave of the heights grows where they begin to lose waves, and no
// longer once these are lost; of noise it is the same at all scales, and of a smooth surface it grows ever faster.
class LostDetail {
 public:
  // Nothing is lost.
  LostDetail() = default;
  explicit LostDetail(PilotPoints table);

  // The squared bias that the loss makes at least in the candidate's H, and likewise in the rest of its shape operator,
  // in 1 / the index's unit of length, squared.
  double SquaredBias(const ScaleCandidate& candidate) const;

  // What the constructor holds of each sampled point.
  static constexpr size_t kBytesPerSample = (kRungCount + 2) * sizeof(double);

 private:
  std::array<double, kRungCount> squared_bias_{};  // of jets of degree 4
};

}  // namespace curvd
