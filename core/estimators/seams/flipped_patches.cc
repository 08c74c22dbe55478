#include "core/estimators/seams/flipped_patches.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/seams/flipped_patches.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/group_points-inl.h"
#include "core/estimators/neighborhood_plan.h"
#include "core/estimators/seams/find_seam-inl.h"
#include "core/estimators/seams/pair_scratch.h"
#include "core/search/group_search-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// What a search finds is read afterwards.
struct NoVisitor {
  HWY_INLINE void Start(size_t) {}
  HWY_INLINE void operator()(const NearPoints&, FloatMask) {}
  HWY_INLINE void Finish() {}
};

// Calls visit(place, neighbor) for the points of a group whose place `is_wanted`, and each of their nearest neighbors.
template <typename IsWanted, typename Visit>
HWY_INLINE absl::Status ForEachNearPair(const SpatialIndex& index, size_t group, PairScratch& s, IsWanted is_wanted,
                                        Visit visit) {
  LoadGroup<true>(index, group, s.points, s.first_point);
  if (s.points.size == 0) return absl::OkStatus();
  const uint64_t began = s.search.work;
  s.search.stopped = s.stopped;
  const SearchPlan plan = PairScratch::Plan(index.point_count());
  GroupSearch search(index, plan, s.points.box, s.search);
  for (size_t i = 0; i < s.points.size; ++i) {
    const auto place = static_cast<size_t>(s.points.place[i]);
    if (!is_wanted(place)) continue;
    QueryPoint query;
    s.points.query.Get(i, query.position);
    s.points.normal.Get(i, query.normal);
    search.Find(query.position, NoVisitor());
    if (s.IsStopped()) return Stopped();
    ForEachCompared(index, s.search.found, query, [&](const ComparedNeighbor& neighbor) { visit(place, neighbor); });
    if (s.search.work - began > s.most_work && i + 1 < s.points.size) {
      s.rest = s.first_point + i + 1;
      break;
    }
  }
  search.PassOn();
  return absl::OkStatus();
}

absl::Status JoinAgreeing(const SpatialIndex& index, size_t group, PairScratch& s, RegionForest& regions) {
  const auto all = [](size_t) { return true; };
  return ForEachNearPair(index, group, s, all, [&](size_t place, const ComparedNeighbor& neighbor) {
    if (!neighbor.Agrees() || !MayLieOnOneSheet(neighbor.AgreeingHeight(), neighbor.Distance())) return;
    regions.Join(place, neighbor.place);
  });
}

absl::Status JoinAcrossSeams(const SpatialIndex& index, const SeamMarks& marks, size_t group, PairScratch& s,
                             RegionForest& regions, std::atomic<uint64_t>& count) {
  const auto is_wanted = [&](size_t place) {
    return marks.IsMarked(place) && regions.MeasuredSize(place) >= FlippedPatches::kLeastPatch;
  };
  return ForEachNearPair(index, group, s, is_wanted, [&](size_t place, const ComparedNeighbor& neighbor) {
    if (!neighbor.IsOpposed() || !MayLieOnOneSheet(neighbor.OpposedHeight(), neighbor.Distance())) return;
    if (regions.MeasuredSize(neighbor.place) < FlippedPatches::kLeastPatch) return;
    if (regions.Join(place, neighbor.place)) count.fetch_add(1, std::memory_order_relaxed);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace curvd {
namespace {

HWY_EXPORT(JoinAgreeing);
HWY_EXPORT(JoinAcrossSeams);

constexpr std::string_view kPatchPhase = "patches";

}  // namespace

std::unique_ptr<WorkerScratch> FlippedPatches::MakeScratch() const { return std::make_unique<PairScratch>(); }

std::vector<GroupPhase> FlippedPatches::Phases() {
  const auto begin = [this]() -> absl::Status {
    absl::StatusOr<RegionForest> regions = RegionForest::Create(index_.point_count());
    if (regions.ok()) regions_ = *std::move(regions);
    return regions.status();
  };
  const auto join = [this](size_t group, WorkerScratch& scratch) {
    return HWY_DYNAMIC_DISPATCH(JoinAgreeing)(index_, group, static_cast<PairScratch&>(scratch), regions_);
  };
  const auto measure = [this](size_t group, WorkerScratch&) {
    MeasureGroup(group);
    return absl::OkStatus();
  };
  const auto count = [this](size_t group, WorkerScratch& scratch) {
    return HWY_DYNAMIC_DISPATCH(JoinAcrossSeams)(index_, marks_, group, static_cast<PairScratch&>(scratch), regions_,
                                                 count_);
  };
  return {{kPatchPhase, begin, join}, {kPatchPhase, nullptr, measure}, {kPatchPhase, nullptr, count}};
}

void FlippedPatches::MeasureGroup(size_t group) {
  const size_t first = group * SpatialIndex::kGroupPoints;
  const size_t last = std::min(first + SpatialIndex::kGroupPoints, index_.point_count());
  for (size_t place = first; place < last; ++place) regions_.Measure(place);
}

}  // namespace curvd

#endif  // HWY_ONCE
