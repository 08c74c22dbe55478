// The phases that give an index normals, or turn those that it has.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/index/spatial_index.h"
#include "core/job/phases/group_phase.h"
#include "core/job/phases/normal_tasks.h"
#include "core/job/scale_attempts.h"
#include "core/normals/normal_fit.h"
#include "core/normals/normal_options.h"
#include "core/normals/normal_pilot.h"
#include "core/normals/normals.h"
#include "core/normals/orientation/link_probe.h"
#include "core/normals/orientation/orientation.h"
#include "core/normals/runs/normal_fit_run.h"
#include "core/normals/sheet_probe.h"
#include "core/normals/trust/side_check.h"
#include "core/normals/trust/side_probe.h"

namespace curvd {

// The name of all phases that make normals; those that turn them, or copy them, are called kOrientationPhase.
inline constexpr std::string_view kNormalsPhase = "normals";

// Bytes a point that making normals as `options` say, for these tasks, needs beyond the cloud and the index, normals
// themselves included; and those of the points that are handed out.
size_t NormalBytesPerPoint(const NormalOptions& options, const NormalTasks& tasks);
// The most bytes of scratch that the threads of a pool hold meanwhile, for a cloud of `point_count` points.
size_t NormalScratchBytes(const NormalOptions& options, const NormalTasks& tasks, size_t point_count, int thread_count);

// Makes normals as options say: estimates them, in phases called kNormalsPhase, then orients them, in phases called
// "orientation" (core/normals/orientation/orientation.h). Each phase adds what follows it. The normals depend on the
// cloud and the options alone: not on threads.
//
// Where the scale is automatic, it may take several attempts (core/job/scale_attempts.h). Whatever the attempt, sides
// of one sheet are made once more without repairs (core/normals/orientation/side_repair.h) where these tear the sheet.
class NormalPhases {
 public:
  // `then` is called once the normals are made; it adds the phases that follow. REQUIRES: options.Validate() is OK, and
  // their source is not kGiven; `index` has normals if it is kOrient; `index`, what `options` refers to, and this
  // outlive the phases. `origin` is the cloud's. `aim` decides for which errors an automatic scale is best.
  NormalPhases(const NormalOptions& options, const NormalTasks& tasks, NormalAim aim,
               const std::array<double, 3>& origin, SpatialIndex& index, int thread_count, PhaseSink add_phase,
               std::function<absl::Status()> then);

  // Adds the first phases. Errors: ErrorKind::kOutOfMemory; may throw std::bad_alloc.
  absl::Status Start();

  // What was found out; of normals that were given, the status counts are those of AddCollection. REQUIRES: `then` was
  // called.
  NormalReport report() const;
  // What the normals in use were made by; null where they were given, or no fit could be made. REQUIRES: `then` was
  // called, or is.
  const NormalFit* fit() const;
  // Whether the point has a normal, and why not. REQUIRES: `then` was called, or is.
  PointStatus status(size_t place) const;
  // Copies the normals in use to a field, in phases that call `then` at their end. REQUIRES: `then` was called, or is.
  absl::Status AddCollection(NormalField& field, std::function<absl::Status()> then);
  size_t bytes() const;

 private:
  // Adds the phases that look at a sample of the cloud, and call Fit at their end.
  void AddLooks();
  absl::Status LookAtLinks();
  std::string_view LookPhase() const;
  // Makes normals and orients them, by the first attempt.
  absl::Status Fit();
  absl::Status AddFit(const ChosenFit& scale);
  void FillTooFew();
  absl::Status EndFit();
  void Orient(bool may_repair = true);
  // Whether the scale of now could be fitted: the cloud has as many points.
  bool HasFit() const;
  // Looks at how much the neighborhoods of the fit are of one side, where there was a fit.
  absl::Status EndOrientation();
  // Makes the next attempt, or is done.
  absl::Status Decide();
  // Whether a repair turned parts of one sheet against the others: where noise differs between parts, such sides may
  // fit a closed surface better than the right ones.
  bool IsTornByRepair() const;
  // Compares the sides of now with those of the attempt before.
  void TakeCheck();
  void Collect(size_t first, size_t last, NormalField& field);

  const NormalOptions options_;
  const NormalTasks tasks_;
  const NormalAim aim_;
  SpatialIndex& index_;
  const int thread_count_;
  const PhaseSink add_phase_;
  NormalQuality quality_;  // empty for given normals
  std::optional<NormalPilot> pilot_;
  std::optional<LinkProbe> link_probe_;
  size_t links_per_point_ = kLinksPerPoint;
  std::optional<SheetProbe> sheet_probe_;
  SheetFinding sheets_;
  std::optional<SideProbe> side_probe_;
  std::optional<ScaleAttempts> attempts_;  // of an automatic scale
  std::optional<SideCheck> side_check_;    // while normals are made whose sides are compared with those before
  ChosenFit scale_;                        // of the normals of now
  bool may_repair_ = true;                 // the orientation of now
  std::unique_ptr<StrategyRun> fit_;
  std::optional<ScratchSet> scratch_;
  NormalReport fit_report_;
  std::atomic<size_t> collected_ = 0;  // points whose normals were handed out
  const std::array<double, 3> origin_;
  const std::function<absl::Status()> then_;
  // One for each scale that was tried; all but the last hold nothing any more. A phase of the last may be running.
  std::vector<std::unique_ptr<Orientation>> orientations_;
};

}  // namespace curvd
