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
  planes_.emplace(index_, max_neighbor_count, thread_count_);
  jets_.emplace(index_, max_neighbor_count, thread_count_);
  return Probe(max_neighbor_count, std::move(then));
}

absl::Status HalfNormalPhases::Probe(uint32_t max_neighbor_count, std::function<absl::Status()> then) {
  const bool looks_at_planes = planes_->AddBlocks();
  if (looks_at_planes || (!planes_->found().has_value() && jets_->AddBlocks())) {
    add_phase_(looks_at_planes ? MakeProbePhase(name_, *planes_) : MakeProbePhase(name_, *jets_));
    add_phase_(MakeStep(name_, [=, this, then = std::move(then)] { return Probe(max_neighbor_count, then); }));
    return absl::OkStatus();
  }
  const std::optional<FoundFit> fit = planes_->found().has_value() ? planes_->found() : jets_->found();
  planes_.reset();
  jets_.reset();
  if (!fit.has_value()) return then();
  sheets_.emplace(index_, max_neighbor_count, thread_count_);
  add_phase_(MakeProbePhase(name_, *sheets_));
  add_phase_(MakeStep(name_, [this, fit = *fit, then = std::move(then)] {
    const bool has_two_sheets = sheets_->Find().two_sheets;
    sheets_.reset();
    if (has_two_sheets) return then();
    given_made_by_ = fit.made_by;
    return MakeOf(fit.of_halves, then);
  }));
  return absl::OkStatus();
}

}  // namespace curvd
