#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/group_estimator.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/delaunay/umbrella-inl.h"
#include "core/estimators/group-inl.h"
#include "hwy/highway.h"

#if HWY_ONCE

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/estimators/group_buffers.h"
#include "core/estimators/group_estimator.h"

namespace curvd {

HWY_EXPORT(EstimateGroupKernel);
HWY_EXPORT(BuildUmbrellasKernel);

GroupScratch::GroupScratch() : buffers_(std::make_unique<Buffers>()) {}
GroupScratch::~GroupScratch() = default;
GroupScratch::GroupScratch(GroupScratch&&) noexcept = default;

const std::array<uint64_t, kPointStatusEnd>& GroupScratch::status_counts() const { return buffers_->status_counts; }

EstimationPlan EstimationPlan::Make(const EstimatorOptions& options, const SpatialIndex& index) {
  // The hexagram's own search only sets its scale: that many neighbors measure the density, and more of them would make
  // its cost grow with K.
  constexpr size_t kHexagramSearch = 48;
  // Targets at two thirds of the radius that holds K points (docs/numerics.md, measured).
  constexpr float kHexagramFactor = 2.0f / 3.0f;
  constexpr double kWholeIndex = 4.0;  // above the squared diagonal of any index
  EstimationPlan plan{};
  plan.estimator = options.estimator;
  plan.max_neighbor_count = options.max_neighbor_count;
  plan.average_normal_weight = static_cast<float>(options.average_normal_weight);
  plan.rotations = options.estimator == EstimatorKind::kAvgHexagram ? static_cast<int>(options.rotation_count) : 1;
  for (int r = 0; r < plan.rotations; ++r) {
    const double angle = std::numbers::pi / 3.0 * r / plan.rotations;
    plan.cosine[r] = static_cast<float>(std::cos(angle));
    plan.sine[r] = static_cast<float>(std::sin(angle));
  }
  plan.triangle_count = options.triangle_count;
  plan.seed = options.seed;
  plan.falloff = options.even_weights ? 0.0f : 1.0f;
  plan.spread = options.even_weights ? 0.0f : 1.0f / 6.0f;
  plan.jet_degree = static_cast<int>(options.jet_degree);
  plan.scale = std::ldexp(1.0, index.scale_exponent());
  plan.half_scale = std::ldexp(1.0f, index.scale_exponent() / 2);
  plan.other_half_scale = std::ldexp(1.0f, index.scale_exponent() - index.scale_exponent() / 2);
  plan.rho_factor = plan.radius_factor = 1.0f;
  const bool hexagram = options.estimator == EstimatorKind::kHexagram;
  if (const auto* radius = std::get_if<NeighborRadius>(&options.neighborhood)) {
    plan.by_radius = true;
    plan.radius = radius->radius;
    const double scaled = radius->radius * plan.scale;
    plan.squared_radius = static_cast<float>(std::min(scaled * scaled, kWholeIndex));
  } else {
    plan.neighbor_count = std::get<NeighborCount>(options.neighborhood).count;
    plan.searched_count = hexagram ? std::min(plan.neighbor_count, kHexagramSearch) : plan.neighbor_count;
    plan.radius_factor = static_cast<float>(std::sqrt(static_cast<double>(plan.neighbor_count) / plan.searched_count));
    plan.rho_factor = plan.radius_factor;
  }
  if (hexagram) plan.rho_factor *= kHexagramFactor;
  return plan;
}

EstimationPlan EstimationPlan::ForUmbrellas(const SpatialIndex& index) {
  EstimationPlan plan{};
  plan.searched_count = std::min<size_t>(kUmbrellaNeighbors + 1, index.point_count());
  return plan;
}

void BuildUmbrellas(const SpatialIndex& index, const EstimationPlan& plan, size_t group, GroupScratch& scratch,
                    Umbrella* umbrellas) {
  HWY_DYNAMIC_DISPATCH(BuildUmbrellasKernel)(index, plan, group, scratch, umbrellas);
}

OversizedNeighborhood EstimateGroup(const SpatialIndex& index, const EstimationPlan& plan, size_t group,
                                    GroupScratch& scratch, PointCurvature* out) {
  return HWY_DYNAMIC_DISPATCH(EstimateGroupKernel)(index, plan, group, scratch, out);
}

}  // namespace curvd

#endif  // HWY_ONCE
