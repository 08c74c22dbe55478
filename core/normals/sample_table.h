// What fits of several candidates show at a sample of the points.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

#include "core/estimators/fits/jet_systems.h"
#include "core/index/spatial_index.h"
#include "core/normals/fits/normal_plan.h"
#include "core/normals/normal_fit.h"

namespace curvd {

// An outcome for each candidate at each sampled point. Const methods are thread-safe, and so are writes of distinct
// outcomes.
class SampleTable {
 public:
  // The first point of each leaf of a group is sampled.
  static constexpr size_t kPointsPerGroup = SpatialIndex::kGroupLeaves;
  // Candidates of one method are a ladder of neighbor counts, of which two rungs double the count.
  static constexpr size_t kRungsPerDoubling = 2;

  struct Candidate {
    NormalFit fit;  // by count
    NormalPlan plan;
    uint32_t count() const { return std::get<NeighborCount>(fit.neighborhood).count; }
    // Of a point, in any unit: a search, and the products of monomials over the neighbors.
    size_t cost() const {
      const size_t of_fit = count() * static_cast<size_t>(8 + JetSize(2 * plan.degree));
      return plan.shares ? of_fit / SpatialIndex::kLeafSize : of_fit;
    }
  };
  // Of one candidate at one sampled point. Lengths are in the index's unit.
  struct Outcome {
    std::array<float, 3> normal;
    float radius;
    float mean_square;  // of the distances of the neighbors from the fit
    float noise;        // the squared error of the normal that noise of unit standard deviation makes
    float excess;       // how many times the noise is that of as many neighbors that fill a disc
    bool is_fitted;     // nothing else is set where it is false
  };

  // No outcome is fitted yet. `groups` are those of the index that are sampled. REQUIRES: candidates of one method lie
  // beside each other, by ever more neighbors; `index` outlives the table.
  SampleTable(const SpatialIndex& index, std::vector<size_t> groups, std::vector<Candidate> candidates);

  const SpatialIndex& index() const { return index_; }
  // That of LatticeStep.
  double lattice_step() const { return lattice_step_; }
  const std::vector<size_t>& groups() const { return groups_; }
  // The mean number of points at the place of one (MeanCopies), of one of `groups`.
  double copies(size_t group) const { return copies_[group]; }
  const std::vector<Candidate>& candidates() const { return candidates_; }
  // Sampled points lie group by group.
  size_t sample_count() const { return groups_.size() * kPointsPerGroup; }

  Outcome& outcome(size_t candidate, size_t sample) { return outcomes_[candidate * sample_count() + sample]; }
  const Outcome& outcome(size_t candidate, size_t sample) const {
    return outcomes_[candidate * sample_count() + sample];
  }
  // How many neighbors more than coefficients a fit has. Copies of a point share its noise: of so many coefficients,
  // each takes the freedom of several neighbors.
  double FreedomAt(size_t candidate, size_t sample) const;

  // But for the plans of the candidates.
  size_t bytes() const {
    return outcomes_.capacity() * sizeof(Outcome) + groups_.capacity() * sizeof(size_t) +
           copies_.capacity() * sizeof(double);
  }

 private:
  const SpatialIndex& index_;
  const double lattice_step_;
  const std::vector<size_t> groups_;
  std::vector<double> copies_;  // by group
  const std::vector<Candidate> candidates_;
  std::vector<Outcome> outcomes_;
};

}  // namespace curvd
