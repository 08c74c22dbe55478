// What a worker needs to look at points beside their nearest neighbors.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/estimators/group_points.h"
#include "core/estimators/seams/normals_agreement.h"
#include "core/estimators/strategy.h"
#include "core/search/search_plan.h"
#include "core/search/search_scratch.h"

namespace curvd {

struct PairScratch final : WorkerScratch {
  SearchScratch search;
  GroupPoints points;

  // The search for near pairs, in an index of so many points: of a point and its nearest neighbors.
  static SearchPlan Plan(size_t point_count) {
    return SearchPlan::ByCount(std::min<size_t>(NormalsAgreement::kNearest + 1, point_count));
  }

  size_t PlaceOf(size_t i) const { return static_cast<size_t>(points.place[i]); }
  // Whether point i of the group gets a result, and is not a neighbor alone.
  bool IsQuery(size_t i) const { return points.slot[i] != GroupPoints::kNoSlot; }

  size_t bytes() const override { return sizeof(*this) + search.bytes(); }
  uint64_t work() const override { return search.work; }
};

}  // namespace curvd
