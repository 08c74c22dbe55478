// The phases that make normals of halves, for estimates that tell noise by them (core/normals/half_normals.h).
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
#include "core/job/group_phase.h"
#include "core/normals/normal_fit.h"
#include "core/normals/orientation.h"
#include "core/normals/sheet_probe.h"
#include "core/normals/trust/jet_probe.h"
#include "core/normals/trust/plane_probe.h"

namespace curvd {

// Options of an estimate that takes about as long for a point as the fit.
EstimatorOptions OptionsForOnePoint(const NormalFit& fit);

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
  // to the positions, and of how many neighbors. Where they are not, or neighborhoods hold two sheets, which fits mix
  // in both halves, there are none.
  absl::Status MakeOfGiven(uint32_t max_neighbor_count, std::function<absl::Status()> then);

  // What given normals were made by, where MakeOfGiven has found that neighbors share what noise of the positions does
  // to them.
  const std::optional<FittedNormals>& given_made_by() const { return given_made_by_; }
  size_t bytes() const {
    return (planes_.has_value() ? planes_->bytes() : 0) + (jets_.has_value() ? jets_->bytes() : 0) +
           (sheets_.has_value() ? sheets_->bytes() : 0);
  }
  // Of the scratch of all workers together, at most, until halves are made of given normals.
  static size_t ScratchBytes(size_t point_count, uint32_t max_neighbor_count, int thread_count);

 private:
  // Each goes on with its probe, then with the next one; the last makes halves of what was found.
  absl::Status ProbePlanes(uint32_t max_neighbor_count, std::function<absl::Status()> then);
  absl::Status ProbeJets(uint32_t max_neighbor_count, std::function<absl::Status()> then);
  absl::Status ProbeSheets(const FoundFit& found, uint32_t max_neighbor_count, std::function<absl::Status()> then);

  SpatialIndex& index_;
  const int thread_count_;
  const std::string_view name_;
  const PhaseSink add_phase_;
  std::optional<PlaneProbe> planes_;
  std::optional<JetProbe> jets_;
  std::optional<SheetProbe> sheets_;
  std::optional<FittedNormals> given_made_by_;
  std::unique_ptr<StrategyRun> run_;
  std::optional<ScratchSet> scratch_;
};

}  // namespace curvd
