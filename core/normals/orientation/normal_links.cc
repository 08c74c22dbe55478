#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/normals/orientation/normal_links.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/normals/orientation/normal_links-inl.h"
#include "hwy/highway.h"

#if HWY_ONCE

#include <bit>

#include "core/normals/orientation/normal_links.h"

namespace curvd {

HWY_EXPORT(AppendLinksKernel);

PackedArea PackArea(float area) { return static_cast<PackedArea>(std::bit_cast<uint32_t>(area) >> 16); }
float UnpackArea(PackedArea area) { return std::bit_cast<float>(static_cast<uint32_t>(area) << 16); }

NeighborhoodPlan LinkSearch(const SpatialIndex& index, size_t links_per_point) {
  EstimatorOptions options;
  options.neighborhood = NeighborCount{static_cast<uint32_t>(std::min(links_per_point + 1, index.point_count()))};
  return NeighborhoodPlan::Make(options, index);
}

absl::Status AppendLinks(const SpatialIndex& index, const NeighborhoodPlan& plan, size_t group, LinkScratch& scratch,
                         PackedArea* areas) {
  return HWY_DYNAMIC_DISPATCH(AppendLinksKernel)(index, plan, group, scratch, areas);
}

}  // namespace curvd

#endif  // HWY_ONCE
