#include "tests/core/normals/made_samples.h"

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/normals/sample_groups.h"
#include "tests/core/normals/normal_clouds.h"

namespace curvd::testing {

SpatialIndex SampledIndex() { return BuildIndex(Torus(20'000, 1).ToCloud()); }

SampleTable PlaneSample(const SpatialIndex& index, const std::function<double(size_t group)>& sigma) {
  constexpr uint32_t kCounts[kMadeCandidates] = {12, 17, 24, 34, 48, 68, 96, 136, 192};
  std::vector<SampleTable::Candidate> candidates;
  for (const uint32_t count : kCounts) {
    NormalFit fit;
    fit.neighborhood = NeighborCount{count};
    candidates.push_back({fit, NormalPlan(fit, index)});
  }
  SampleTable table(index, SampleGroups(index, 128), std::move(candidates));
  for (size_t c = 0; c < kMadeCandidates; ++c) {
    const double count = kCounts[c], radius = 0.01 * std::sqrt(count);
    for (size_t i = 0; i < table.sample_count(); ++i) {
      const double noise = sigma(i / SampleTable::kPointsPerGroup);
      table.outcome(c, i) = {.normal = {0.0f, 0.0f, 1.0f},
                             .radius = static_cast<float>(radius),
                             .mean_square = static_cast<float>(noise * noise * table.FreedomAt(c, i) / count),
                             .noise = static_cast<float>(8.0 / (count * radius * radius)),
                             .excess = 1.0f,
                             .is_fitted = true};
    }
  }
  return table;
}

}  // namespace curvd::testing
