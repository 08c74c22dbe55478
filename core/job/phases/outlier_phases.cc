#include "core/job/phases/outlier_phases.h"

#include <memory>
#include <utility>

#include "core/base/function_phase.h"

namespace curvd {
namespace {

constexpr size_t kBlockPoints = 100'000;  // are copied in a few milliseconds

}  // namespace

OutlierPhases::OutlierPhases(SpatialIndex& index, size_t size, bool has_own_normals, OutlierSearch search,
                             int thread_count, PhaseSink add_phase)
    : index_(index),
      size_(size),
      has_own_normals_(has_own_normals),
      search_(search),
      thread_count_(thread_count),
      add_phase_(std::move(add_phase)) {}

void OutlierPhases::Start(const PointCurvature* results, std::function<absl::Status()> if_none,
                          std::function<void()> if_some) {
  if_none_ = std::move(if_none);
  if_some_ = std::move(if_some);
  run_.emplace(index_, results, has_own_normals_, search_);
  scratch_.emplace(*run_, thread_count_);
  for (GroupPhase& phase : run_->Phases()) {
    add_phase_(MakeGroupPhase(std::move(phase), index_, GroupsPerBlock({}), *scratch_, nullptr));
  }
  add_phase_(MakeStep(kOutlierPhase, [this] { return EndLook(); }));
}

size_t OutlierPhases::bytes() const {
  return (run_.has_value() ? run_->bytes() : 0) + (rest_of_cloud_.has_value() ? rest_of_cloud_->bytes() : 0) +
         (rest_.has_value() ? rest_->cloud.bytes() : 0);
}

absl::Status OutlierPhases::EndLook() {
  outliers_ = run_->TakeOutliers();
  scratch_.reset();
  run_.reset();
  if (outliers_.empty()) return if_none_();
  if_some_();
  return MakeRest();
}

absl::Status OutlierPhases::MakeRest() {
  rest_of_cloud_.emplace(index_, size_, has_own_normals_);
  if (absl::Status status = rest_of_cloud_->Allocate(); !status.ok()) return status;
  add_phase_(MakeLoop(kOutlierPhase, size_, kBlockPoints,
                      [this](size_t first, size_t last) { rest_of_cloud_->Clear(first, last); }));
  add_phase_(MakeLoop(kOutlierPhase, index_.leaf_count(), kBlockPoints / SpatialIndex::kLeafSize,
                      [this](size_t first, size_t last) { rest_of_cloud_->Place(first, last); }));
  // Points are appended in their order: each block adds the next one.
  const auto begin = [this]() -> absl::StatusOr<size_t> {
    rest_of_cloud_->LeaveOut(outliers_);
    rest_of_cloud_->StartCloud();
    index_ = SpatialIndex();
    return 1;
  };
  const auto append = [this](const BlockContext& context) {
    absl::Status status = rest_of_cloud_->Append(context.block);
    if (status.ok() && context.block + 1 < rest_of_cloud_->block_count()) context.add_block(context.block + 1);
    return status;
  };
  const auto end = [this] {
    rest_ = Rest{rest_of_cloud_->Take(), std::move(outliers_)};
    rest_of_cloud_.reset();
    return absl::OkStatus();
  };
  add_phase_(std::make_unique<FunctionPhase>(kOutlierPhase, PhaseFunctions{.begin = begin, .run = append, .end = end}));
  return absl::OkStatus();
}

}  // namespace curvd
