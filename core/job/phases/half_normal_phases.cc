#include "core/job/phases/half_normal_phases.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "core/base/function_phase.h"
#include "core/normals/runs/half_normals.h"

namespace curvd {

absl::Status HalfNormalPhases::MakeOf(const NormalFit& fit, std::function<absl::Status()> then) {
  if (!HasHalves(fit, index_)) return then();
  if (absl::Status status = index_.MakeHalfNormals(); !status.ok()) return status;
  run_ = StartHalfNormals(fit, index_);
  scratch_.emplace(*run_, thread_count_);
  for (GroupPhase& groups : run_->Phases()) {
    groups.name = name_;
    add_phase_(MakeGroupPhase(std::move(groups), index_, GroupsPerBlock(fit.OptionsForOnePoint()), *scratch_, nullptr));
  }
  add_phase_(MakeStep(name_, [this, then = std::move(then)] {
    if (!AreHalfNormals(scratch_->status_counts())) index_.DropHalfNormals();
    scratch_.reset();
    run_.reset();
    return then();
  }));
  return absl::OkStatus();
}

size_t HalfNormalPhases::ScratchBytes(size_t point_count, uint32_t max_neighbor_count, int thread_count,
                                      bool makes_anew) {
  // Workers make scratch with their first block, which is one group, or one group and one of so many fits at once.
  constexpr size_t kMostFits = JetProbe::kMostAtOnce;
  const size_t groups = (point_count + SpatialIndex::kGroupPoints - 1) / SpatialIndex::kGroupPoints;
  const size_t threads = static_cast<size_t>(thread_count);
  const size_t planes = PlaneProbe::ScratchBytes(point_count, max_neighbor_count);
  const size_t jets = JetProbe::ScratchBytes(point_count, max_neighbor_count);
  if (planes == 0 && jets == 0) return 0;
  const size_t noise = makes_anew ? NoiseProbe::ScratchBytes(point_count, max_neighbor_count) : 0;
  const size_t sheets = SheetProbe::ScratchBytes(point_count, max_neighbor_count);
  const size_t refit = makes_anew ? RefitPhases::ScratchBytes(point_count, max_neighbor_count, thread_count) : 0;
  return std::max({std::min(threads, groups) * std::max(planes, noise),
                   std::min(threads, kMostFits * groups) * std::max(jets, sheets), refit});
}

absl::Status HalfNormalPhases::MakeOfGiven(uint32_t max_neighbor_count, bool makes_anew,
                                           std::function<absl::Status()> then) {
  max_neighbor_count_ = max_neighbor_count;
  makes_anew_ = makes_anew;
  planes_.emplace(index_, max_neighbor_count, thread_count_);
  return ProbePlanes(std::move(then));
}

absl::Status HalfNormalPhases::ProbePlanes(std::function<absl::Status()> then) {
  if (planes_->AddBlocks()) {
    add_phase_(MakeProbePhase(name_, *planes_));
    add_phase_(MakeStep(name_, [this, then = std::move(then)] { return ProbePlanes(then); }));
    return absl::OkStatus();
  }
  const std::optional<FoundFit> planes = planes_->found();
  planes_.reset();
  if (IsOfUse(planes)) return ProbeSheets([this, planes, then] { return UseFit(*planes, then); }, then);
  jets_.emplace(index_, max_neighbor_count_, thread_count_);
  return ProbeJets(std::move(then));
}

absl::Status HalfNormalPhases::ProbeJets(std::function<absl::Status()> then) {
  if (jets_->AddBlocks()) {
    add_phase_(MakeProbePhase(name_, *jets_));
    add_phase_(MakeStep(name_, [this, then = std::move(then)] { return ProbeJets(then); }));
    return absl::OkStatus();
  }
  const std::optional<FoundFit> jets = jets_->found();
  const bool may_follow_noise = makes_anew_ && !jets.has_value() && !jets_->IsNoiseNegligible();
  jets_.reset();
  if (IsOfUse(jets)) return ProbeSheets([this, jets, then] { return UseFit(*jets, then); }, then);
  if (!may_follow_noise) return then();
  noise_.emplace(index_, max_neighbor_count_, thread_count_);
  return ProbeNoise(std::move(then));
}

absl::Status HalfNormalPhases::ProbeNoise(std::function<absl::Status()> then) {
  if (noise_->AddBlocks()) {
    add_phase_(MakeProbePhase(name_, *noise_));
    add_phase_(MakeStep(name_, [this, then = std::move(then)] { return ProbeNoise(then); }));
    return absl::OkStatus();
  }
  const std::optional<double> error = noise_->SquaredError();
  noise_.reset();
  return error.has_value() ? ProbeSheets([this, error, then] { return UseNoise(*error, then); }, then) : then();
}

bool HalfNormalPhases::IsOfUse(const std::optional<FoundFit>& found) const {
  return found.has_value() && (makes_anew_ || found->of_halves.has_value());
}

absl::Status HalfNormalPhases::ProbeSheets(std::function<absl::Status()> use, std::function<absl::Status()> then) {
  sheets_.emplace(index_, max_neighbor_count_, thread_count_);
  add_phase_(MakeProbePhase(name_, *sheets_));
  add_phase_(MakeStep(name_, [this, use = std::move(use), then = std::move(then)] {
    const bool has_two_sheets = sheets_->Find().two_sheets;
    sheets_.reset();
    return has_two_sheets ? then() : use();
  }));
  return absl::OkStatus();
}

absl::Status HalfNormalPhases::UseFit(const FoundFit& found, std::function<absl::Status()> then) {
  const auto keep_given = [this, found, then] {
    if (!found.of_halves.has_value()) return then();
    given_made_by_ = found.made_by;
    return MakeOf(*found.of_halves, then);
  };
  if (!makes_anew_) return keep_given();
  refit_.emplace(index_, max_neighbor_count_, thread_count_, name_, add_phase_);
  refit_->StartFrom(found.made_by, [this, found, then, keep_given](const NormalFit* fit) {
    if (fit == nullptr) return keep_given();
    given_made_by_ = found.made_by;
    return TakeAnew(*fit, then);
  });
  return absl::OkStatus();
}

absl::Status HalfNormalPhases::UseNoise(double squared_error, std::function<absl::Status()> then) {
  refit_.emplace(index_, max_neighbor_count_, thread_count_, name_, add_phase_);
  refit_->StartFrom(squared_error, [this, then = std::move(then)](const NormalFit* fit) {
    return fit == nullptr ? then() : TakeAnew(*fit, then);
  });
  return absl::OkStatus();
}

absl::Status HalfNormalPhases::TakeAnew(const NormalFit& fit, std::function<absl::Status()> then) {
  made_anew_by_ = {fit.method, std::get<NeighborCount>(fit.neighborhood).count};
  return MakeOf(fit, std::move(then));
}

}  // namespace curvd
