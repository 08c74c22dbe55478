#include "core/estimators/seams/agreement_run.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/seams/agreement_run.cc"
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

// Calls visit(i, neighbor) for the points of a group whose place `is_wanted`, and each of their nearest neighbors, the
// point itself among them. `s.points` has the points.
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
    if (!is_wanted(s.PlaceOf(i))) continue;
    QueryPoint query;
    s.points.query.Get(i, query.position);
    s.points.normal.Get(i, query.normal);
    search.Find(query.position, NoVisitor());
    if (s.IsStopped()) return Stopped();
    ForEachCompared(index, s.search.found, query, [&](const ComparedNeighbor& neighbor) { visit(i, neighbor); });
    if (s.search.work - began > s.most_work && i + 1 < s.points.size) {
      s.rest = s.first_point + i + 1;
      break;
    }
  }
  search.PassOn();
  return absl::OkStatus();
}

// Joins the points of near pairs that agree. Adds the number of near pairs.
absl::Status JoinAgreeing(const SpatialIndex& index, size_t group, PairScratch& s, RegionForest& regions,
                          std::atomic<uint64_t>& near_pairs) {
  uint64_t count = 0;
  const auto all = [](size_t) { return true; };
  const absl::Status status = ForEachNearPair(index, group, s, all, [&](size_t i, const ComparedNeighbor& neighbor) {
    const size_t place = s.PlaceOf(i);
    if (neighbor.place == place) return;
    count += s.IsQuery(i) ? 1 : 0;
    if (neighbor.Agrees() && MayLieOnOneSheet(neighbor.AgreeingHeight(), neighbor.Distance())) {
      regions.Join(place, neighbor.place);
    }
  });
  near_pairs.fetch_add(count, std::memory_order_relaxed);
  return status;
}

// Links regions at seams. Adds the number of opposed pairs, and of the links that made one piece of two.
absl::Status LinkRegions(const SpatialIndex& index, const SeamMarks& marks, size_t group, PairScratch& s,
                         RegionForest& regions, std::atomic<uint64_t>& opposed_pairs, std::atomic<uint64_t>& links) {
  if (!marks.AnyInGroup(group)) return absl::OkStatus();
  uint64_t opposed = 0, linked = 0;
  const auto is_region = [&](size_t place) { return regions.MeasuredSize(place) >= NormalsAgreement::kLeastPatch; };
  const auto is_marked = [&](size_t place) { return marks.IsMarked(place); };
  const auto link = [&](size_t i, const ComparedNeighbor& neighbor) {
    if (!neighbor.IsOpposed() || !MayLieOnOneSheet(neighbor.OpposedHeight(), neighbor.Distance())) return;
    opposed += s.IsQuery(i) ? 1 : 0;
    const size_t place = s.PlaceOf(i);
    if (is_region(place) && is_region(neighbor.place)) linked += regions.Join(place, neighbor.place) ? 1 : 0;
  };
  const absl::Status status = ForEachNearPair(index, group, s, is_marked, link);
  opposed_pairs.fetch_add(opposed, std::memory_order_relaxed);
  links.fetch_add(linked, std::memory_order_relaxed);
  return status;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace curvd {
namespace {

HWY_EXPORT(JoinAgreeing);
HWY_EXPORT(LinkRegions);

constexpr std::string_view kAgreementPhase = "agreement";

}  // namespace

std::unique_ptr<WorkerScratch> AgreementRun::MakeScratch() const { return std::make_unique<PairScratch>(); }

std::vector<GroupPhase> AgreementRun::Phases() {
  const auto begin = [this]() -> absl::Status {
    absl::StatusOr<RegionForest> regions = RegionForest::Create(index_.point_count());
    if (!regions.ok()) return regions.status();
    regions_ = *std::move(regions);
    return absl::OkStatus();
  };
  const auto join = [this](size_t group, WorkerScratch& scratch) {
    auto& s = static_cast<PairScratch&>(scratch);
    return HWY_DYNAMIC_DISPATCH(JoinAgreeing)(index_, group, s, regions_, near_pairs_);
  };
  const auto measure = [this](size_t group, WorkerScratch&) {
    MeasureGroup(group);
    return absl::OkStatus();
  };
  const auto link = [this](size_t group, WorkerScratch& scratch) {
    auto& s = static_cast<PairScratch&>(scratch);
    const auto kernel = HWY_DYNAMIC_DISPATCH(LinkRegions);
    return kernel(index_, marks_, group, s, regions_, opposed_pairs_, flipped_patches_);
  };
  return {{kAgreementPhase, begin, join}, {kAgreementPhase, nullptr, measure}, {kAgreementPhase, nullptr, link}};
}

void AgreementRun::MeasureGroup(size_t group) {
  const size_t first = group * SpatialIndex::kGroupPoints;
  const size_t last = std::min(first + SpatialIndex::kGroupPoints, index_.point_count());
  for (size_t place = first; place < last; ++place) regions_.Measure(place);
}

}  // namespace curvd

#endif  // HWY_ONCE
