#include "core/job/phases/refit_phases.h"

#include <algorithm>

#include "core/base/function_phase.h"
#include "core/normals/runs/normal_refit.h"

namespace curvd {
namespace {

// Of the squared error that noise makes of given normals, what new ones may err by at most. Measured on 455 clouds of
// all kinds whose normals were fits: where that is so, H errs by half as much in the geometric mean; where it is
// not, by up to 60 times as much.
constexpr double kMostOfGivenError = 0.5;

}  // namespace

void RefitPhases::StartFrom(const FittedNormals& made_by, Then then) {
  const auto noise_of_given = [made_by](const NormalPilot& pilot) {
    return pilot.NoiseOf(made_by.method, made_by.neighbor_count).value_or(0.0);
  };
  Start(noise_of_given, std::move(then));
}

void RefitPhases::StartFrom(double squared_error, Then then) {
  Start([squared_error](const NormalPilot&) { return squared_error; }, std::move(then));
}

void RefitPhases::Start(GivenError given_error, Then then) {
  pilot_.emplace(index_, std::nullopt, max_neighbor_count_, thread_count_, NormalAim::kCurvature);
  add_phase_(MakeProbePhase(name_, *pilot_));
  add_phase_(MakeStep(name_, [this, given_error = std::move(given_error), then = std::move(then)] {
    return Decide(given_error, then);
  }));
}

absl::Status RefitPhases::Decide(const GivenError& given_error, const Then& then) {
  const ChosenFit chosen = pilot_->Choose();
  const double most = kMostOfGivenError * given_error(*pilot_);
  pilot_.reset();
  if (!(chosen.squared_error <= most)) return then(nullptr);
  if (absl::Status status = index_.MakeHalfNormals(); !status.ok()) return status;
  run_ = StartNormalRefit(chosen.fit, index_);
  scratch_.emplace(*run_, thread_count_);
  for (GroupPhase& groups : run_->Phases()) {
    groups.name = name_;
    const size_t groups_per_block = GroupsPerBlock(chosen.fit.OptionsForOnePoint());
    add_phase_(MakeGroupPhase(std::move(groups), index_, groups_per_block, *scratch_, nullptr));
  }
  add_phase_(MakeStep(name_, [this, fit = chosen.fit, then] {
    scratch_.reset();
    run_.reset();
    index_.TakeHalfNormals();
    return then(&fit);
  }));
  return absl::OkStatus();
}

size_t RefitPhases::ScratchBytes(size_t point_count, uint32_t max_neighbor_count, int thread_count) {
  const size_t blocks = NormalPilot::MostBlocks(point_count, max_neighbor_count);
  return std::min(static_cast<size_t>(thread_count), blocks) *
         NormalPilot::ScratchBytes(point_count, max_neighbor_count);
}

}  // namespace curvd
