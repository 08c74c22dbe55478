#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/estimators/fits/jet.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/estimators/fits/jet-inl.h"
#include "core/estimators/fits/repeated_search-inl.h"
#include "core/estimators/fits/shape_operator-inl.h"
#include "core/estimators/group_estimate-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

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
  const auto collect = [&](GroupSearch& search, size_t i) HWY_ATTR {
    QueryPoint query;
    NormalSums normals;
    s.points.query.Get(i, query.position);
    s.points.normal.Get(i, query.normal);
    search.Find(query.position, NeighborCollector(index, query, s.neighbors, normals));
  };
  SolveJets(plan.degree, s.frames.rho, s.neighbors, s.qr_room, s.points, s.system, s.shapes,
            RepeatedSearch(index, plan.neighborhood.search, plan.degree, s, collect));
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
