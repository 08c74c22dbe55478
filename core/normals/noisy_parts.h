// Where one part of a cloud is much noisier than the other, each gets a scale of its own.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/normals/sample_table.h"
#include "core/normals/sample_view.h"

namespace curvd {

// Two parts of a sample, of which one is noisier.
struct SampleParts {
  std::vector<bool> is_noisy;     // by group
  std::vector<double> variances;  // likewise, by the probe
  std::vector<double> noises;     // likewise: the variance of the noise; 0 where it may be that of bends
  uint32_t probe_count;           // as NoisyPart has it, and the next two
  double least_variance, quiet_variance;
  double noisy_share;  // of the groups
};

// How fits of degree 2 part the sample; none where they do not, or where bends of the surface do.
std::optional<SampleParts> FindParts(const SampleTable& table);

// The noisy part, or the quiet one. Outcomes of the quiet one that have neighbors of the noisy part among theirs are
// mixed. REQUIRES: FindParts found the parts in this table, which outlives the view.
SampleView ViewOf(const SampleTable& table, const SampleParts& parts, bool noisy);

}  // namespace curvd
