// The run of a strategy that needs one pass over the groups.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/estimators/strategy.h"

namespace curvd {

// `Plan` is what the strategy derives from options and index, `Scratch` its worker's scratch.
template <typename Plan, typename Scratch>
class SinglePhaseRun final : public StrategyRun {
 public:
  // Estimates the points of one group and writes their results.
  using Kernel = absl::Status (*)(const SpatialIndex& index, const Plan& plan, size_t group, Scratch& scratch,
                                  PointCurvature* results);

  // The index and the results outlive the run.
  SinglePhaseRun(const SpatialIndex& index, Plan plan, PointCurvature* results, Kernel kernel)
      : index_(index), plan_(std::move(plan)), results_(results), kernel_(kernel) {}

  std::unique_ptr<WorkerScratch> MakeScratch() const override { return std::make_unique<Scratch>(); }

  std::vector<GroupPhase> Phases() override {
    return {{"curvature", nullptr, [this](size_t group, WorkerScratch& scratch) {
               return kernel_(index_, plan_, group, static_cast<Scratch&>(scratch), results_);
             }}};
  }

 private:
  const SpatialIndex& index_;
  const Plan plan_;
  PointCurvature* const results_;
  const Kernel kernel_;
};

}  // namespace curvd
