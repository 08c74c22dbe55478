// The phases that look for outliers once a cloud is estimated, and make a cloud of the rest where there are some.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "core/cloud/cloud.h"
#include "core/estimators/curvature_field.h"
#include "core/index/spatial_index.h"
#include "core/job/phases/group_phase.h"
#include "core/normals/orientation/orientation.h"
#include "core/scale/outliers/outlier_run.h"
#include "core/scale/outliers/rest_of_cloud.h"

namespace curvd {

class OutlierPhases {
 public:
  // What is to be estimated once more.
  struct Rest {
    Cloud cloud;                    // the outliers are invalid points of it
    std::vector<int32_t> outliers;  // their ranks, in any order
  };

  // `index` is that of a cloud of `size` points. `has_own_normals`: whether the normals came with it, so that single
  // ones may be wrong, and the rest keeps them. REQUIRES: as OutlierRun and RestOfCloud; `index` and this outlive the
  // phases.
  OutlierPhases(SpatialIndex& index, size_t size, bool has_own_normals, OutlierSearch search, int thread_count,
                PhaseSink add_phase);

  // Adds the phases that look at the results of an estimate, by slot. If there are no outliers, `if_none` is called,
  // which adds the phases that follow. Else `if_some` is, which frees what nobody needs any more, the results among it;
  // the rest is made, which takes the index, and no other phase follows. May throw std::bad_alloc.
  void Start(const PointCurvature* results, std::function<absl::Status()> if_none, std::function<void()> if_some);

  // REQUIRES: the phases have ended.
  std::optional<Rest> TakeRest() { return std::move(rest_); }
  size_t bytes() const;

 private:
  absl::Status EndLook();
  absl::Status MakeRest();

  SpatialIndex& index_;
  const size_t size_;
  const bool has_own_normals_;
  const OutlierSearch search_;
  const int thread_count_;
  const PhaseSink add_phase_;
  std::function<absl::Status()> if_none_;
  std::function<void()> if_some_;
  std::optional<OutlierRun> run_;
  std::optional<ScratchSet> scratch_;
  std::vector<int32_t> outliers_;  // while the rest is made
  std::optional<RestOfCloud> rest_of_cloud_;
  std::optional<Rest> rest_;
};

}  // namespace curvd
