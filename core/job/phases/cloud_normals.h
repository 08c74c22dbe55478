// The phases that see to the normals of a cloud, between its index and what needs normals.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <string_view>

#include "absl/status/status.h"
#include "core/estimators/curvature_field.h"
#include "core/estimators/options.h"
#include "core/index/spatial_index.h"
#include "core/job/phases/group_phase.h"
#include "core/job/phases/half_normal_phases.h"
#include "core/job/phases/normal_phases.h"
#include "core/job/phases/normal_tasks.h"
#include "core/normals/normal_options.h"
#include "core/normals/normals.h"
#include "core/normals/trust/fitted_normals.h"
#include "core/normals/trust/surface_probe.h"

namespace curvd {

// The name of what is done for an estimate before its strategy begins; it counts as part of the estimate.
inline constexpr std::string_view kFieldPhase = "field";

// Looks whether normals that came with the cloud stand on its surface; makes or turns them, where the options say so;
// hands them out, likewise; and makes normals of halves, where an estimate compares those.
class CloudNormals {
 public:
  // `estimate`: what the normals are for (TasksFor); none: they are what comes out. `options` are the caller's. `then`
  // is called at the end; it adds the phases that follow. REQUIRES: `index`, what the options refer to, and this
  // outlive the phases. `origin` is that of the cloud.
  CloudNormals(const std::optional<EstimatorOptions>& estimate, const NormalOptions& options,
               const std::array<double, 3>& origin, SpatialIndex& index, int thread_count, PhaseSink add_phase,
               std::function<absl::Status()> then);

  // Adds the first phases. Errors: ErrorKind::kInvalid if there are no normals, and none are to be made, but they are
  // to be turned or handed out; ErrorKind::kOutOfMemory. May throw std::bad_alloc.
  absl::Status Start();

  // Of what follows, all is known once `then` is called.

  // How far normals that came with the cloud are off its surface, if it tells.
  const std::optional<NormalsOffSurface>& off_surface() const { return off_surface_; }
  // Whether points may lack a normal that others have; else all have the status kOk.
  bool may_lack() const { return phases_.has_value(); }
  PointStatus status(size_t place) const { return may_lack() ? phases_->status(place) : PointStatus::kOk; }
  bool LacksSome() const;
  // What was found out as normals were made, turned or handed out; none where they were left as they came.
  std::optional<NormalReport> report() const;
  // What given normals were made by (HalfNormalPhases), and what they were made anew by.
  std::optional<FittedNormals> given_made_by() const;
  std::optional<FittedNormals> made_anew_by() const;
  // Those that are handed out; empty unless the tasks say so.
  NormalField& field() { return field_; }

  size_t bytes() const;

 private:
  // Each adds its phases, which go on with the next one.
  absl::Status LookAtSurface();
  absl::Status Make();
  absl::Status StartPhases();
  absl::Status HandOut();
  absl::Status MakeHalves();

  const std::optional<EstimatorOptions> estimate_;
  const NormalOptions options_;
  const NormalTasks tasks_;
  const std::array<double, 3> origin_;
  SpatialIndex& index_;
  const int thread_count_;
  const PhaseSink add_phase_;
  const std::function<absl::Status()> then_;
  std::optional<SurfaceProbe> surface_;
  std::optional<NormalsOffSurface> off_surface_;
  std::optional<NormalPhases> phases_;      // none where they stay as they came
  std::optional<HalfNormalPhases> halves_;  // none where nobody compares halves
  NormalField field_;
};

}  // namespace curvd
