// The phases that make normals of halves, for estimates that tell noise by them (core/normals/runs/half_normals.h), and
// those that find out before what given normals were made by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "core/index/spatial_index.h"
#include "core/job/phases/group_phase.h"
#include "core/job/phases/refit_phases.h"
#include "core/normals/normal_fit.h"
#include "core/normals/orientation/orientation.h"
#include "core/normals/sheet_probe.h"
#include "core/normals/trust/fitted_normals.h"
#include "core/normals/trust/jet_probe.h"
#include "core/normals/trust/noise_probe.h"
#include "core/normals/trust/plane_probe.h"

namespace curvd {

class HalfNormalPhases {
 public:
  // Phases have the name. REQUIRES: `index`, and this, outlive them.
  HalfNormalPhases(SpatialIndex& index, int thread_count, std::string_view name, PhaseSink add_phase)
      : index_(index), thread_count_(thread_count), name_(name), add_phase_(std::move(add_phase)) {}

  // Makes half normals as the index's normals were made, if a half of the neighbors tells enough, then calls `then`,
  // which adds the phases that follow. REQUIRES: index.has_normals(), and they have their sides.
  // Errors: ErrorKind::kOutOfMemory; may throw std::bad_alloc.
  absl::Status MakeOf(const NormalFit& fit, std::function<absl::Status()> then);
  // The same for normals that somebody else made: finds out whether they are those of planes or jets that were fitted
  // to the positions, and of how many neighbors; or, if `makes_anew`, whether their errors follow the noise of the
  // positions in whatever way (core/normals/trust/noise_probe.h). If `makes_anew`, the normals themselves are then made
  // anew where that is better (core/job/phases/refit_phases.h). There are no halves where the normals are those of no
  // fit, or err by bends of the surface as much as by noise, or where neighborhoods hold two sheets, which fits mix in
  // both halves.
  absl::Status MakeOfGiven(uint32_t max_neighbor_count, bool makes_anew, std::function<absl::Status()> then);

  // What given normals were made by, where MakeOfGiven has found that neighbors share what noise of the positions does
  // to them, or has made them anew.
  const std::optional<FittedNormals>& given_made_by() const { return given_made_by_; }
  // What they were made anew by, if they were.
  const std::optional<FittedNormals>& made_anew_by() const { return made_anew_by_; }
  size_t bytes() const {
    return (planes_.has_value() ? planes_->bytes() : 0) + (jets_.has_value() ? jets_->bytes() : 0) +
           (noise_.has_value() ? noise_->bytes() : 0) + (sheets_.has_value() ? sheets_->bytes() : 0) +
           (refit_.has_value() ? refit_->bytes() : 0);
  }
  // Of the scratch of all workers together, at most, until halves are made of given normals.
  static size_t ScratchBytes(size_t point_count, uint32_t max_neighbor_count, int thread_count, bool makes_anew);

 private:
  // Each goes on with its probe, then with the next one; the last makes use of what was found.
  absl::Status ProbePlanes(std::function<absl::Status()> then);
  absl::Status ProbeJets(std::function<absl::Status()> then);
  absl::Status ProbeNoise(std::function<absl::Status()> then);
  // Calls `use` where neighborhoods hold one sheet, and else `then`.
  absl::Status ProbeSheets(std::function<absl::Status()> use, std::function<absl::Status()> then);
  // Whether something follows from such a fit.
  bool IsOfUse(const std::optional<FoundFit>& found) const;
  absl::Status UseFit(const FoundFit& found, std::function<absl::Status()> then);
  // The same where normals follow the noise of the positions, but are those of no fit that is known.
  absl::Status UseNoise(double squared_error, std::function<absl::Status()> then);
  absl::Status TakeAnew(const NormalFit& fit, std::function<absl::Status()> then);

  SpatialIndex& index_;
  const int thread_count_;
  const std::string_view name_;
  const PhaseSink add_phase_;
  std::optional<PlaneProbe> planes_;
  std::optional<JetProbe> jets_;
  std::optional<NoiseProbe> noise_;
  std::optional<SheetProbe> sheets_;
  std::optional<RefitPhases> refit_;
  uint32_t max_neighbor_count_ = 0;
  bool makes_anew_ = false;
  std::optional<FittedNormals> given_made_by_, made_anew_by_;
  std::unique_ptr<StrategyRun> run_;
  std::optional<ScratchSet> scratch_;
};

}  // namespace curvd
