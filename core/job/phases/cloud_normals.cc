#include "core/job/phases/cloud_normals.h"

#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/function_phase.h"

namespace curvd {
namespace {

constexpr size_t kBlockLeaves = 6'000;  // are copied in a millisecond or two

}  // namespace

CloudNormals::CloudNormals(const std::optional<EstimatorOptions>& estimate, const NormalOptions& options,
                           const std::array<double, 3>& origin, SpatialIndex& index, int thread_count,
                           PhaseSink add_phase, std::function<absl::Status()> then)
    : estimate_(estimate),
      options_(options),
      tasks_(TasksFor(estimate, options)),
      origin_(origin),
      index_(index),
      thread_count_(thread_count),
      add_phase_(std::move(add_phase)),
      then_(std::move(then)) {}

absl::Status CloudNormals::Start() {
  if (options_.source == NormalSource::kEstimate || !index_.has_normals()) return Make();
  surface_.emplace(index_, options_.max_neighbor_count, thread_count_);
  return LookAtSurface();
}

bool CloudNormals::LacksSome() const {
  if (!may_lack()) return false;
  for (size_t place = 0; place < index_.point_count(); ++place) {
    if (status(place) != PointStatus::kOk) return true;
  }
  return false;
}

std::optional<NormalReport> CloudNormals::report() const {
  if (!phases_.has_value()) return std::nullopt;
  return phases_->report();
}

std::optional<FittedNormals> CloudNormals::given_made_by() const {
  return halves_.has_value() ? halves_->given_made_by() : std::nullopt;
}

std::optional<FittedNormals> CloudNormals::made_anew_by() const {
  return halves_.has_value() ? halves_->made_anew_by() : std::nullopt;
}

size_t CloudNormals::bytes() const {
  return field_.bytes() + (surface_.has_value() ? surface_->bytes() : 0) +
         (phases_.has_value() ? phases_->bytes() : 0) + (halves_.has_value() ? halves_->bytes() : 0);
}

absl::Status CloudNormals::LookAtSurface() {
  if (surface_->AddBlocks()) {
    const std::string_view name = estimate_.has_value() ? kFieldPhase : kOrientationPhase;
    add_phase_(MakeProbePhase(name, *surface_));
    add_phase_(MakeStep(name, [this] { return LookAtSurface(); }));
    return absl::OkStatus();
  }
  off_surface_ = surface_->found();
  surface_.reset();
  return Make();
}

absl::Status CloudNormals::Make() {
  if (options_.source == NormalSource::kGiven && !tasks_.returns_normals) return MakeHalves();
  if (options_.source != NormalSource::kEstimate && !index_.has_normals()) {
    return MakeCoreError(ErrorKind::kInvalid, "the cloud has no normals; ask for estimated ones");
  }
  if (options_.source == NormalSource::kOrient && index_.keeps_given_normals() && index_.point_count() > 0) {
    if (absl::Status status = index_.MakeGivenNormals(); !status.ok()) return status;
    const auto keep = [this](size_t first, size_t last) {
      for (size_t leaf = first; leaf < last; ++leaf) index_.KeepGivenNormals(leaf);
    };
    add_phase_(MakeLoop(kOrientationPhase, index_.leaf_count(), kBlockLeaves, keep, [this] { return StartPhases(); }));
    return absl::OkStatus();
  }
  return StartPhases();
}

absl::Status CloudNormals::StartPhases() {
  phases_.emplace(options_, tasks_, estimate_.has_value() ? NormalAim::kCurvature : NormalAim::kNormals, origin_,
                  index_, thread_count_, add_phase_, [this] { return HandOut(); });
  return options_.source == NormalSource::kGiven ? HandOut() : phases_->Start();
}

absl::Status CloudNormals::HandOut() {
  if (!tasks_.returns_normals) return MakeHalves();
  return phases_->AddCollection(field_, [this] { return MakeHalves(); });
}

absl::Status CloudNormals::MakeHalves() {
  if (!tasks_.makes_halves || !index_.has_normals()) return then_();
  const bool are_made = options_.source == NormalSource::kEstimate;
  halves_.emplace(index_, thread_count_, are_made ? kNormalsPhase : kFieldPhase, add_phase_);
  if (!are_made) return halves_->MakeOfGiven(estimate_->max_neighbor_count, tasks_.makes_fits_anew, then_);
  const NormalFit* const fit = phases_->fit();
  return fit != nullptr ? halves_->MakeOf(*fit, then_) : then_();
}

}  // namespace curvd
