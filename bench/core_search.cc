#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bench/core_search.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/group-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

template <Wanted kWanted>
HWY_INLINE void SearchGroups(const SpatialIndex& index, const EstimationPlan& plan, float* radii) {
  GroupScratch scratch;
  GroupScratch::Buffers& b = scratch.buffers();
  const auto unit = static_cast<float>(1.0 / plan.scale);
  for (size_t group = 0; group < index.group_count(); ++group) {
    const Box box = LoadGroup(index, group, b);
    GroupSearch<kWanted> search(index, plan, box, b);
    for (size_t i = 0; i < b.size; ++i) radii[b.id[i]] = std::sqrt(search.Find(i)) * unit;
    b.reach_hint = search.largest_squared_radius();
  }
}

void SearchGroupsKernel(const SpatialIndex& index, const EstimationPlan& plan, float* radii) {
  if (plan.estimator == EstimatorKind::kHexagram) {
    SearchGroups<Wanted::kNormalSum>(index, plan, radii);
  } else {
    SearchGroups<Wanted::kNeighbors>(index, plan, radii);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

#include "bench/core_search.h"
#include "core/index/index_builder.h"
#include "core/search/kth_neighbor.h"

namespace curvd {
HWY_EXPORT(SearchGroupsKernel);

namespace bench {

SpatialIndex BuildIndex(Cloud cloud) {
  IndexBuilder builder(std::move(cloud));
  if (const absl::Status status = builder.Start(); !status.ok()) {
    std::fprintf(stderr, "%s\n", status.ToString().c_str());
    std::exit(1);
  }
  while (builder.block_count() > 0) {
    for (size_t block = 0; block < builder.block_count(); ++block) builder.RunBlock(block);
    builder.EndPhase();
  }
  std::vector<IndexBuilder::Part> open = {builder.root()};
  while (!open.empty()) {
    const IndexBuilder::Part part = open.back();
    open.pop_back();
    builder.Build(part, [&](const IndexBuilder::Part& half) { open.push_back(half); });
  }
  return builder.Take();
}

void SearchByGroups(const SpatialIndex& index, EstimatorKind estimator, uint32_t k, float* radii) {
  EstimatorOptions options;
  options.estimator = estimator;
  options.neighborhood = NeighborCount{k};
  const EstimationPlan plan = EstimationPlan::Make(options, index);
  HWY_DYNAMIC_DISPATCH(SearchGroupsKernel)(index, plan, radii);
}

void SearchByDescent(const SpatialIndex& index, uint32_t k, float* radii) {
  std::vector<NeighborRank> heap;
  const double unit = std::ldexp(1.0, -index.scale_exponent());
  for (size_t leaf = 0; leaf < index.leaf_count(); ++leaf) {
    const SpatialIndex::LeafPositions& points = index.positions(leaf);
    for (int i = 0; i < index.LeafPoints(leaf); ++i) {
      const float query[3] = {points.x[i], points.y[i], points.z[i]};
      const float squared = KthNeighbor(index, query, k, heap).squared_distance;
      radii[points.id[i]] = static_cast<float>(std::sqrt(squared) * unit);
    }
  }
}

}  // namespace bench
}  // namespace curvd

#endif  // HWY_ONCE
