#include "core/normals/sample_table.h"

#include <algorithm>
#include <utility>

#include "core/normals/mean_copies.h"
#include "core/normals/sample_groups.h"

namespace curvd {

SampleTable::SampleTable(const SpatialIndex& index, std::vector<size_t> groups, std::vector<Candidate> candidates)
    : index_(index),
      lattice_step_(LatticeStep(index)),
      groups_(std::move(groups)),
      candidates_(std::move(candidates)),
      outcomes_(candidates_.size() * sample_count()) {
  copies_.reserve(groups_.size());
  for (const size_t group : groups_) copies_.push_back(MeanCopies(index, group));
}

double SampleTable::FreedomAt(size_t candidate, size_t sample) const {
  const int coefficients = JetSize(std::max(candidates_[candidate].plan.degree, 1));
  return candidates_[candidate].count() - coefficients * copies_[sample / kPointsPerGroup];
}

}  // namespace curvd
