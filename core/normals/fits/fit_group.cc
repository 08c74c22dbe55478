#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/normals/fits/fit_group.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/normals/fits/group_fit-inl.h"
#include "hwy/highway.h"

#if HWY_ONCE

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/normals/edges/edge_fits.h"
#include "core/normals/fits/fit_group.h"
#include "core/normals/normal_fit.h"

namespace curvd {
namespace {

HWY_EXPORT(FitGroupKernel);

// How far the points of a group, one of each leaf, lie from their fits, squared, in the median; 0 without a fit. Of all
// runs of the group's points, and of fits to halves, the same.
absl::StatusOr<double> VarianceOf(const SpatialIndex& index, const NormalPlan& plan, size_t group, NormalScratch& s) {
  NormalPlan whole = plan;
  whole.half.reset();
  const size_t first_point = std::exchange(s.first_point, 0);
  const uint64_t most_work = std::exchange(s.most_work, std::numeric_limits<uint64_t>::max());
  const auto take = std::exchange(s.take, nullptr);
  const absl::Status status = HWY_DYNAMIC_DISPATCH(FitGroupKernel)(index, whole, group, GroupSample::kOneOfEachLeaf, s);
  s.first_point = first_point;
  s.most_work = most_work;
  s.take = take;
  if (!status.ok()) return status;
  std::vector<double> variances;
  for (size_t i = 0; i < s.points.size; ++i) {
    const double rho = s.frames.rho[i];
    if (s.points.status[i] == PointStatus::kOk) variances.push_back(s.mean_square[i] * rho * rho);
  }
  return variances.empty() ? 0.0 : Median(variances);
}

}  // namespace

absl::StatusOr<const NormalPlan*> PlanOfGroup(const SpatialIndex& index, const NormalPlan& plan, size_t group,
                                              NormalScratch& scratch) {
  if (plan.noisy == nullptr) return &plan;
  const NoisyPlan& noisy = *plan.noisy;
  const absl::StatusOr<double> probed = VarianceOf(index, noisy.probe, group, scratch);
  if (!probed.ok()) return probed.status();
  if (*probed >= noisy.least_variance) return &noisy.fit;
  const double least_mixed = NoisyPart::kMixedRatio * std::max(*probed, noisy.quiet_variance);
  for (const NormalPlan& quiet : noisy.quiet) {
    if (&quiet == &noisy.quiet.back()) break;
    const absl::StatusOr<double> variance = VarianceOf(index, quiet, group, scratch);
    if (!variance.ok()) return variance.status();
    if (*variance < least_mixed) return &quiet;
  }
  return &noisy.quiet.back();
}

absl::Status FitChosen(const SpatialIndex& index, const NormalPlan& plan, size_t group, GroupSample sample,
                       NormalScratch& scratch) {
  return HWY_DYNAMIC_DISPATCH(FitGroupKernel)(index, plan, group, sample, scratch);
}

absl::Status FitGroup(const SpatialIndex& index, const NormalPlan& plan, size_t group, GroupSample sample,
                      NormalScratch& scratch) {
  const absl::StatusOr<const NormalPlan*> own = PlanOfGroup(index, plan, group, scratch);
  if (!own.ok()) return own.status();
  scratch.is_noisy = plan.noisy != nullptr && *own == &plan.noisy->fit;
  if (plan.edges != nullptr) return FitBesideEdges(index, plan, group, sample, scratch);
  return HWY_DYNAMIC_DISPATCH(FitGroupKernel)(index, **own, group, sample, scratch);
}

}  // namespace curvd

#endif  // HWY_ONCE
