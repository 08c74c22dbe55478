// The phases that make given normals anew, where these follow the noise of the positions, as fits do, and curvd makes
// better ones of them.
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
#include "core/normals/normal_fit.h"
#include "core/normals/normal_pilot.h"
#include "core/normals/orientation/orientation.h"
#include "core/normals/trust/fitted_normals.h"

namespace curvd {

class RefitPhases {
 public:
  // Gets the fit that the normals were made anew by; null: they stay as they were given. It adds the phases that
  // follow.
  using Then = std::function<absl::Status(const NormalFit*)>;

  // Phases have the name. REQUIRES: `index`, and this, outlive them.
  RefitPhases(SpatialIndex& index, uint32_t max_neighbor_count, int thread_count, std::string_view name,
              PhaseSink add_phase)
      : index_(index),
        max_neighbor_count_(max_neighbor_count),
        thread_count_(thread_count),
        name_(name),
        add_phase_(std::move(add_phase)) {}

  // Makes the normals anew, each on the side that it has, if that is expected to take away half of their squared error
  // by noise or more; then calls `then`. REQUIRES: the index's normals are fits to the positions as `made_by` says, of
  // neighborhoods that hold one sheet. May throw std::bad_alloc.
  void StartFrom(const FittedNormals& made_by, Then then);
  // The same where it is not known how they were made, but what they err by, squared, in radians.
  void StartFrom(double squared_error, Then then);

  size_t bytes() const { return pilot_.has_value() ? pilot_->bytes() : 0; }
  // Of the scratch of all workers together, at most.
  static size_t ScratchBytes(size_t point_count, uint32_t max_neighbor_count, int thread_count);

 private:
  // Asked once the pilot has run.
  using GivenError = std::function<double(const NormalPilot& pilot)>;
  void Start(GivenError given_error, Then then);
  absl::Status Decide(const GivenError& given_error, const Then& then);

  SpatialIndex& index_;
  const uint32_t max_neighbor_count_;
  const int thread_count_;
  const std::string_view name_;
  const PhaseSink add_phase_;
  std::optional<NormalPilot> pilot_;
  std::unique_ptr<StrategyRun> run_;
  std::optional<ScratchSet> scratch_;
};

}  // namespace curvd
