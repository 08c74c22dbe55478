#include "core/job/half_normal_phases.h"

#include <algorithm>
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

size_t HalfNormalPhases::ScratchBytes(size_t point_count, uint32_t max_neighbor_count, int thread_count) {
  // Workers make scratch with their first block, which is one group, or one group and one of so many fits at once.
  constexpr size_t kMostFits = JetProbe::kMostAtOnce;
  const size_t groups = (point_count + SpatialIndex::kGroupPoints - 1) / SpatialIndex::kGroupPoints;
  const size_t threads = static_cast<size_t>(thread_count);
  const size_t planes = PlaneProbe::ScratchBytes(point_count, max_neighbor_count);
  const size_t jets = JetProbe::ScratchBytes(point_count, max_neighbor_count);
  if (planes == 0 && jets == 0) return 0;
  const size_t sheets = SheetProbe::ScratchBytes(point_count, max_neighbor_count);
  return std::max(std::min(threads, groups) * planes, std::min(threads, kMostFits * groups) * std::max(jets, sheets));
}

absl::Status HalfNormalPhases::MakeOfGiven(uint32_t max_neighbor_count, std::function<absl::Status()> then) {
  planes_.emplace(index_, max_neighbor_count, thread_count_);
  return ProbePlanes(max_neighbor_count, std::move(then));
}

absl::Status HalfNormalPhases::ProbePlanes(uint32_t max_neighbor_count, std::function<absl::Status()> then) {
  if (planes_->AddBlocks()) {
    add_phase_(MakeProbePhase(name_, *planes_));
    add_phase_(MakeStep(name_, [=, this, then = std::move(then)] { return ProbePlanes(max_neighbor_count, then); }));
    return absl::OkStatus();
  }
  const std::optional<FoundFit> planes = planes_->found();
  planes_.reset();
  if (planes.has_value()) return ProbeSheets(*planes, max_neighbor_count, std::move(then));
  jets_.emplace(index_, max_neighbor_count, thread_count_);
  return ProbeJets(max_neighbor_count, std::move(then));
}

absl::Status HalfNormalPhases::ProbeJets(uint32_t max_neighbor_count, std::function<absl::Status()> then) {
  if (jets_->AddBlocks()) {
    add_phase_(MakeProbePhase(name_, *jets_));
    add_phase_(MakeStep(name_, [=, this, then = std::move(then)] { return ProbeJets(max_neighbor_count, then); }));
    return absl::OkStatus();
  }
  const std::optional<FoundFit> jets = jets_->found();
  jets_.reset();
  return jets.has_value() ? ProbeSheets(*jets, max_neighbor_count, std::move(then)) : then();
}

absl::Status HalfNormalPhases::ProbeSheets(const FoundFit& found, uint32_t max_neighbor_count,
                                           std::function<absl::Status()> then) {
  sheets_.emplace(index_, max_neighbor_count, thread_count_);
  add_phase_(MakeProbePhase(name_, *sheets_));
  add_phase_(MakeStep(name_, [this, found, then = std::move(then)] {
    const bool has_two_sheets = sheets_->Find().two_sheets;
    sheets_.reset();
    if (has_two_sheets) return then();
    given_made_by_ = found.made_by;
    return MakeOf(found.of_halves, then);
  }));
  return absl::OkStatus();
}

}  // namespace curvd
