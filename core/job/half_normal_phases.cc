#include "core/job/half_normal_phases.h"

#include <utility>
#include <variant>

#include "core/base/function_phase.h"
#include "core/normals/half_normals.h"

namespace curvd {

EstimatorOptions OptionsForOnePoint(const NormalFit& fit) {
  EstimatorOptions options = fit.ToEstimatorOptions();
  auto* const neighbors = std::get_if<NeighborCount>(&options.neighborhood);
  if (fit.shares && neighbors != nullptr) neighbors->count /= SpatialIndex::kLeafSize;
  return options;
}

absl::Status HalfNormalPhases::MakeOf(const NormalFit& fit, std::function<absl::Status()> then) {
  if (!HasHalves(fit, index_)) return then();
  if (absl::Status status = index_.MakeHalfNormals(); !status.ok()) return status;
  run_ = StartHalfNormals(fit, index_);
  scratch_.emplace(*run_, thread_count_);
  for (GroupPhase& groups : run_->Phases()) {
    groups.name = name_;
    add_phase_(MakeGroupPhase(std::move(groups), index_, GroupsPerBlock(OptionsForOnePoint(fit)), *scratch_, nullptr));
  }
  add_phase_(MakeStep(name_, [this, then = std::move(then)] {
    if (!AreHalfNormals(scratch_->status_counts())) index_.DropHalfNormals();
    scratch_.reset();
    run_.reset();
    return then();
  }));
  return absl::OkStatus();
}

absl::Status HalfNormalPhases::MakeOfGiven(uint32_t max_neighbor_count, std::function<absl::Status()> then) {
  probe_.emplace(index_, max_neighbor_count, thread_count_);
  return Probe(std::move(then));
}

absl::Status HalfNormalPhases::Probe(std::function<absl::Status()> then) {
  if (probe_->AddFits()) {
    add_phase_(MakeFitProbePhase(*probe_, name_));
    add_phase_(MakeStep(name_, [this, then = std::move(then)] { return Probe(then); }));
    return absl::OkStatus();
  }
  const std::optional<NormalFit> fit = probe_->found();
  probe_.reset();
  given_are_fitted_ = fit.has_value();
  return fit.has_value() ? MakeOf(*fit, std::move(then)) : then();
}

}  // namespace curvd
