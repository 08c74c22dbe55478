// A run that fits the points of a cloud, group by group, and writes what comes out.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "core/estimators/strategy.h"
#include "core/index/spatial_index.h"
#include "core/normals/fits/fit_group.h"
#include "core/normals/fits/normal_plan.h"
#include "core/normals/fits/normal_scratch.h"

namespace curvd {

// One phase, "normals", for each of its fits. Thread-safe as StrategyRun is: distinct groups, with distinct scratch.
class FitRun : public StrategyRun {
 public:
  std::unique_ptr<WorkerScratch> MakeScratch() const final { return std::make_unique<NormalScratch>(); }

  std::vector<GroupPhase> Phases() final {
    std::vector<GroupPhase> phases;
    for (const NormalPlan& plan : plans_) {
      phases.push_back({"normals", nullptr, [this, &plan](size_t group, WorkerScratch& scratch) {
                          return RunGroup(plan, group, static_cast<NormalScratch&>(scratch));
                        }});
    }
    return phases;
  }

 protected:
  // REQUIRES: `index` outlives the run.
  FitRun(SpatialIndex& index, std::vector<NormalPlan> plans) : index_(index), plans_(std::move(plans)) {}

  // Writes what the scratch has of point i of its group, and counts its status. Nothing that fits of other groups read.
  virtual void Write(size_t i, NormalScratch& s) const = 0;

  SpatialIndex& index() const { return index_; }

 private:
  absl::Status RunGroup(const NormalPlan& plan, size_t group, NormalScratch& s) const {
    if (absl::Status status = FitGroup(index_, plan, group, GroupSample::kAll, s); !status.ok()) return status;
    for (size_t i = 0; i < s.points.size; ++i) Write(i, s);
    if (plan.half.has_value()) s.LeaveRestAfterLast(group);
    return absl::OkStatus();
  }

  SpatialIndex& index_;
  const std::vector<NormalPlan> plans_;
};

}  // namespace curvd
