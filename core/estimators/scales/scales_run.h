// The run of a strategy that estimates each point at several scales, with one search for the largest.
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/estimators/strategy.h"

namespace curvd {

// `Scratch` is what the strategy keeps for each worker at one scale, derived of GroupScratch. The first one searches.
template <typename Scratch>
struct ScalesScratch final : WorkerScratch {
  explicit ScalesScratch(size_t scale_count) : squared_radii(scale_count) {
    for (size_t scale = 0; scale < scale_count; ++scale) scales.push_back(std::make_unique<Scratch>());
  }

  std::vector<std::unique_ptr<Scratch>> scales;
  std::vector<float> squared_radii;  // of the last point's neighborhoods; 0: unknown. Only seeds what narrows them

  SeamMarks* SeamsOf(size_t scale) const { return seams == nullptr ? nullptr : seams + scale; }

  size_t bytes() const override {
    size_t bytes = sizeof(*this) + scales.capacity() * sizeof(scales[0]) + squared_radii.capacity() * sizeof(float);
    for (const auto& scratch : scales) bytes += scratch->bytes();
    return bytes;
  }
  uint64_t work() const override { return scales[0]->work(); }
  // `largest` is what the first scratch holds at most, and `smaller` any other one.
  static size_t MostBytes(size_t largest, size_t smaller, size_t scale_count) {
    return sizeof(ScalesScratch) + largest + (scale_count - 1) * smaller +
           scale_count * (2 * sizeof(scales[0]) + sizeof(float));
  }

  // Lends the first scratch what this one was told of the run, and takes back what it tells.
  void StartRun() {
    Scratch& first = *scales[0];
    for (const auto& scratch : scales) scratch->RunWithin(*this, most_work);
    first.seams = seams;
  }
  void EndRun() {
    rest = scales[0]->rest;
    for (const auto& scratch : scales) {
      for (int status = 0; status < kPointStatusEnd; ++status) {
        status_counts[status] += std::exchange(scratch->status_counts[status], 0);
      }
    }
  }
};

// `Plan` is what the strategy derives from the options of one scale and the index.
template <typename Plan, typename Scratch>
class ScalesRun final : public StrategyRun {
 public:
  using Results = std::span<PointCurvature* const>;
  // Estimates the points of one group at all scales and writes their results.
  using Kernel = absl::Status (*)(const SpatialIndex& index, std::span<const Plan> plans, size_t group,
                                  ScalesScratch<Scratch>& scratch, Results results);

  // `make_plan(options, index)` makes the plan of a scale of `options`. The index and the results outlive the run.
  template <typename MakePlan>
  ScalesRun(const EstimatorOptions& options, const SpatialIndex& index, Results results, MakePlan make_plan,
            Kernel kernel)
      : index_(index), results_(results.begin(), results.end()), kernel_(kernel) {
    for (size_t scale = 0; scale < options.scale_count(); ++scale) {
      plans_.push_back(make_plan(options.AtScale(scale), index));
    }
  }

  std::unique_ptr<WorkerScratch> MakeScratch() const override {
    return std::make_unique<ScalesScratch<Scratch>>(plans_.size());
  }

  std::vector<GroupPhase> Phases() override {
    return {{"curvature", nullptr, [this](size_t group, WorkerScratch& scratch) {
               return kernel_(index_, plans_, group, static_cast<ScalesScratch<Scratch>&>(scratch), results_);
             }}};
  }

 private:
  const SpatialIndex& index_;
  std::vector<Plan> plans_;
  const std::vector<PointCurvature*> results_;
  const Kernel kernel_;
};

}  // namespace curvd
