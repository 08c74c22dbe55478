#include "core/scale/detail/detail_run.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/scale/automatic_options.h"
#include "core/scale/collect.h"
#include "core/scale/detail/interval_climb.h"
#include "core/scale/normal_fits/field_curvature.h"
#include "core/scale/normal_fits/sorted_normals.h"

namespace curvd {

DetailRun::DetailRun(const EstimatorOptions& options, const SpatialIndex& index, const CloudChoice& choice,
                     PointCurvature* results)
    : options_(options), index_(index), results_(results) {
  for (size_t part = 0; part < choice.parts().size(); ++part) {
    const std::optional<DetailCheck>& check = choice.parts()[part].check;
    if (!check.has_value()) continue;
    EstimatorOptions largest;
    largest.neighborhood = NeighborCount{kScaleRungs[check->candidate.rung + 1]};  // what counts looks farther
    plans_[part] = NeighborhoodPlan::Make(largest, index);
  }
}

absl::Status DetailRun::Estimate(size_t group, AutomaticScratch& s) const {
  for (size_t part = 0; part < CloudChoice::kMostParts; ++part) {
    std::array<size_t, SpatialIndex::kGroupPoints> kept;
    size_t kept_count = 0;
    const auto is_kept = [&](size_t i) { return i < s.points.size && s.has_detail[i] && s.part[i] == part; };
    for (size_t i = 0; i < s.points.size; ++i) {
      if (is_kept(i)) kept[kept_count++] = i;
    }
    if (kept_count == 0) continue;
    s.pilot.stopped = s.stopped;
    s.pilot.first_point = s.first_point;
    s.pilot.most_work = std::numeric_limits<uint64_t>::max();  // a group's points are few
    const absl::Status status = CollectNeighbors(index_, plans_[part], group, CollectedPoints::kQueries, s.pilot,
                                                 is_kept, [&](size_t place) { EstimatePoint(place, kept[place], s); });
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

void DetailRun::EstimatePoint(size_t place, size_t point, AutomaticScratch& s) const {
  PilotScratch& found = s.pilot;
  found.search.work += 16 * found.neighbors.count;
  float normal[3];
  found.points.normal.Get(place, normal);
  const double to_caller = std::ldexp(1.0, index_.scale_exponent());
  const double most_radius = ScaleOf(options_).max_radius;
  double most = std::min<double>(std::numeric_limits<float>::max(), s.edge_distances[point] * to_caller);
  if (most_radius > 0.0) most = std::min(most, most_radius * to_caller);
  SortNormals(static_cast<float>(most), found);
  PointCurvature& result = results_[found.points.slot[place]];
  const auto estimate = EstimateDetail(found.normals, Eigen::Vector3d(normal[0], normal[1], normal[2]),
                                       ScaleOf(options_).least_count, result.mean / to_caller);
  if (!estimate.has_value()) return;
  const auto scaled = Scaled(estimate->point, to_caller);
  if (!scaled.has_value()) return;
  result = *scaled;
  s.own_fits[point] = OwnFit{
      static_cast<float>(estimate->neighbor_count), static_cast<float>(estimate->mean_error * to_caller),
      static_cast<float>(estimate->k1_error * to_caller), static_cast<float>(estimate->k2_error * to_caller), false};
}

}  // namespace curvd
