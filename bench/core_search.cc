#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bench/core_search.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include <cmath>

#include "core/estimators/group_points-inl.h"
#include "core/estimators/neighbors/neighbors-inl.h"
#include "core/search/group_search-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

void SearchGroupsKernel(const SpatialIndex& index, const SearchPlan& plan, bool collect, float* radii) {
  SearchScratch scratch;
  GroupPoints points;
  NeighborArrays neighbors;
  QueryPoint query;
  NormalSums normals;
  const auto unit = static_cast<float>(std::ldexp(1.0, -index.scale_exponent()));
  for (size_t group = 0; group < index.group_count(); ++group) {
    LoadGroup(index, group, points);
    GroupSearch search(index, plan, points.box, scratch);
    for (size_t i = 0; i < points.size; ++i) {
      points.query.Get(i, query.position);
      points.normal.Get(i, query.normal);
      const float squared = collect ? search.Find(query.position, NeighborCollector(index, query, neighbors, normals))
                                    : search.Find(query.position, NormalSummer(index, query, normals));
      radii[points.slot[i]] = std::sqrt(squared) * unit;
    }
    search.PassOn();
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <algorithm>
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

void SearchByGroups(const SpatialIndex& index, std::string_view estimator, uint32_t k, float* radii) {
  // The hexagram searches for its scale alone (core/estimators/hexagram/hexagram.cc).
  constexpr uint32_t kHexagramSearch = 48;
  const bool hexagram = estimator == "hexagram";
  const SearchPlan plan = SearchPlan::ByCount(hexagram ? std::min(k, kHexagramSearch) : k);
  HWY_DYNAMIC_DISPATCH(SearchGroupsKernel)(index, plan, !hexagram, radii);
}

void SearchByDescent(const SpatialIndex& index, uint32_t k, float* radii) {
  ScratchArray<NeighborRank> heap;
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
