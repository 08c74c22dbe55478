#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/fits/jet.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include <optional>

#include "core/estimators/fits/jet-inl.h"
#include "core/estimators/fits/shape_operator-inl.h"
#include "core/estimators/group_estimate-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Collects the neighbors of single points of a group once more.
class RepeatedSearch {
 public:
  RepeatedSearch(const SpatialIndex& index, const JetPlan& plan, JetScratch& s)
      : index_(index), plan_(plan), s_(s), began_(s.search.work) {}

  // Returns false, and collects nothing, once nobody wants the result, or the group has been ended before point i
  // because the factorizations of those before it took so much.
  HWY_NOINLINE bool operator()(size_t i) {
    if (s_.IsStopped()) return false;
    if (i > 0 && s_.IsLongSince(began_)) {
      s_.LeaveRest(i);
      return false;
    }
    if (!search_.has_value()) search_.emplace(index_, plan_.neighborhood.search, s_.points.box, s_.search);
    QueryPoint query;
    NormalSums normals;
    s_.points.query.Get(i, query.position);
    s_.points.normal.Get(i, query.normal);
    search_->Find(query.position, NeighborCollector(index_, query, s_.neighbors, normals));
    // A step for every four multiplications and additions of the factorization.
    const auto size = static_cast<size_t>(JetSize(plan_.degree));
    s_.search.work += s_.neighbors.count * size * size / 2;
    return true;
  }

 private:
  const SpatialIndex& index_;
  const JetPlan& plan_;
  JetScratch& s_;
  const uint64_t began_;
  std::optional<GroupSearch> search_;
};

absl::Status EstimateJets(const SpatialIndex& index, const JetPlan& plan, size_t group, JetScratch& s,
                          PointCurvature* results) {
  const auto fill = [](size_t) {};
  StartGroup(index, group, s, results, fill);
  const auto sum = [&](size_t i, const LeafList&) {
    PointStatus& status = s.points.status[i];
    // Jets find frames of their own.
    PreparePoints<false>(OnePoint(), plan.neighborhood, s.neighborhoods, i, s.points, s.frames, fill);
    if (status != PointStatus::kOk) return;
    if (s.neighbors.count < static_cast<size_t>(JetSize(plan.degree))) {
      status = PointStatus::kSingularFit;
      return s.frames.Fill(i);
    }
    SumJet(s.neighbors, s.frames.rho[i], plan.degree, i, s.columns, s.system);
  };
  const absl::Status status = ForEachCollected(index, plan.neighborhood, s.neighbors, s, sum);
  if (!status.ok()) return status;
  SolveJets(plan.degree, s.frames.rho, s.neighbors, s.qr_room, s.points, s.system, s.shapes,
            RepeatedSearch(index, plan, s));
  if (s.IsStopped()) return Stopped();
  WriteShapes(plan.neighborhood, s.shapes, s, results);
  return status;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <algorithm>
#include <array>

#include "core/estimators/fits/fit_scratch.h"
#include "core/estimators/single_phase_run.h"
#include "core/estimators/strategy.h"

namespace curvd {
namespace {

HWY_EXPORT(EstimateJets);

absl::Status EstimateGroup(const SpatialIndex& index, const JetPlan& plan, size_t group, JetScratch& s,
                           PointCurvature* results) {
  return HWY_DYNAMIC_DISPATCH(EstimateJets)(index, plan, group, s, results);
}

constexpr std::array<OptionName, 1> kOptions = {"jet_degree"};

std::unique_ptr<StrategyRun> Start(const EstimatorOptions& options, const SpatialIndex& index,
                                   PointCurvature* results) {
  return std::make_unique<SinglePhaseRun<JetPlan, JetScratch>>(index, JetPlan(options, index), results, EstimateGroup);
}

}  // namespace

extern const Strategy kJet = {.name = "jet",
                              .wire_name = "JET_FITTING",
                              .summary = "a polynomial of degree jet_degree as height over the tangent plane",
                              .options = kOptions,
                              .needs_normals = true,
                              .bytes_per_point = 0,
                              .scratch_bytes = JetScratch::MostBytes,
                              .start = Start};

}  // namespace curvd

#endif  // HWY_ONCE
