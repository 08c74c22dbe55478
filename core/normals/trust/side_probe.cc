#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/normals/trust/side_probe.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/group_estimate-inl.h"
#include "core/normals/orientation/normal_links-inl.h"
#include "core/normals/trust/side_probe.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// A comparison that costs at most so much is of two points along one sheet. Pairs across a plate as thin as its points
// are apart cost 0.8 and more, those on a ball of 450 points 0.2 (CompareNormals).
inline constexpr float kMostPairCost = 0.5f;

// Counts the neighbors of `query` by the side of their normals: same, or opposed. Those without a normal (NaN) are
// neither.
class SideCounter {
 public:
  struct Counts {
    size_t same = 0, opposed = 0;
  };
  // `query` is that of the moment, whenever the search shows neighbors.
  SideCounter(const SpatialIndex& index, const QueryPoint& query, Counts& counts)
      : index_(&index), query_(&query), counts_(&counts) {}

  HWY_INLINE void Start(size_t) {
    *counts_ = {};
    comparer_.Start(*query_);
  }
  HWY_INLINE void operator()(const NearPoints& near, FloatMask inside) {
    const FloatTag d;
    const SpatialIndex::LeafNormals& normals = index_->normals(near.leaf);
    const FloatVec agreement = comparer_.Agreement(
        hn::Load(d, normals.x + near.place), hn::Load(d, normals.y + near.place), hn::Load(d, normals.z + near.place));
    const FloatVec zero = hn::Zero(d);
    counts_->same += hn::CountTrue(d, hn::And(inside, hn::Ge(agreement, zero)));
    counts_->opposed += hn::CountTrue(d, hn::And(inside, hn::Lt(agreement, zero)));
  }
  HWY_INLINE void Finish() {}

 private:
  const SpatialIndex* index_;
  const QueryPoint* query_;
  Counts* counts_;
  NormalComparer comparer_;
};

// Adds what the points of a group say.
inline absl::Status ProbeSidesKernel(const SpatialIndex& index, const NeighborhoodPlan& fit,
                                     const NeighborhoodPlan& links, size_t group, bool takes_all, GroupScratch& s,
                                     SideCounts& out) {
  LoadGroup<true>(index, group, s.points);
  if (!takes_all) KeepFirstOfLeaves(s.points);
  QueryPoint query;
  SideCounter::Counts counts;
  const auto add_share = [&](size_t, const LeafList&) {
    const size_t both = counts.same + counts.opposed;
    if (both == 0) return;
    out.opposed_shares += static_cast<double>(counts.opposed) / static_cast<double>(both);
    ++out.points;
  };
  const absl::Status status =
      ForEachNeighborhood(index, fit, query, kNoNormals, SideCounter(index, query, counts), s, add_share);
  if (!status.ok()) return status;
  LinkNeighbors neighbors;
  const auto add_pairs = [&](size_t i, const LeafList&) HWY_ATTR {
    CompareNormals(s.points.normal.x[i], s.points.normal.y[i], s.points.normal.z[i], neighbors);
    for (size_t j = 0; j < neighbors.count; ++j) {
      // NaN where one of both has no normal. Each point is a neighbor of itself.
      if (neighbors.place[j] == s.points.place[i] || !(neighbors.cost[j] <= kMostPairCost)) continue;
      ++out.pairs;
      out.torn_pairs += neighbors.agreement[j] < 0.0f ? 1 : 0;
    }
  };
  return ForEachNeighborhood(index, links, query, kNoNormals, LinkCollector(index, query, neighbors), s, add_pairs);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <algorithm>

#include "absl/status/statusor.h"
#include "core/normals/fits/fit_group.h"
#include "core/normals/sample_groups.h"

namespace curvd {
namespace {

HWY_EXPORT(ProbeSidesKernel);

constexpr size_t kMostSideGroups = 128;
// Of smaller clouds all points are looked at; of larger ones, the first of each leaf of those groups, and all of noisy
// groups: few pairs there lie along the sheet.
constexpr size_t kSmallCloud = kMostSideGroups * SpatialIndex::kGroupPoints;

}  // namespace

SideProbe::SideProbe(const SpatialIndex& index, const NormalFit& fit, int thread_count)
    : index_(index),
      fit_(fit, index),
      links_(LinkSearch(index)),
      groups_(SampleGroups(index, kMostSideGroups)),
      counts_(groups_.size()),
      scratch_(thread_count) {}

absl::Status SideProbe::RunBlock(size_t block, int worker, const std::atomic<bool>& stopped) {
  NormalScratch& scratch = scratch_.Of(worker, stopped);
  const absl::StatusOr<const NormalPlan*> plan = PlanOfGroup(index_, fit_, groups_[block], scratch);
  if (!plan.ok()) return plan.status();
  SideCounts& counts = counts_[block];
  counts.is_noisy = fit_.noisy != nullptr && *plan == &fit_.noisy->fit;
  const bool is_small = index_.point_count() <= kSmallCloud;
  if (counts.is_noisy && !is_small) counts.weight = 1.0 / SpatialIndex::kLeafSize;
  return HWY_DYNAMIC_DISPATCH(ProbeSidesKernel)(index_, (*plan)->neighborhood, links_, groups_[block],
                                                is_small || counts.is_noisy, scratch, counts);
}

double SideProbe::OpposedShare() const {
  double shares = 0.0, points = 0.0;
  for (const SideCounts& counts : counts_) {
    shares += counts.weight * counts.opposed_shares;
    points += counts.weight * static_cast<double>(counts.points);
  }
  return points > 0.0 ? shares / points : 0.0;
}

double SideProbe::TornShare() const {
  // Fewer pairs of a part tell nothing: one of them would be too many.
  constexpr double kFewestOfPart = 400.0;
  double torn[2] = {}, pairs[2] = {};  // of the quiet part, and of the noisy one
  for (const SideCounts& counts : counts_) {
    torn[counts.is_noisy ? 1 : 0] += static_cast<double>(counts.torn_pairs);
    pairs[counts.is_noisy ? 1 : 0] += static_cast<double>(counts.pairs);
  }
  const double all = pairs[0] + pairs[1];
  double most = all > 0.0 ? (torn[0] + torn[1]) / all : 0.0;
  for (const int part : {0, 1}) {
    if (pairs[part] >= kFewestOfPart) most = std::max(most, torn[part] / pairs[part]);
  }
  return most;
}

}  // namespace curvd

#endif  // HWY_ONCE
