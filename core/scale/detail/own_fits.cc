#include "core/scale/detail/own_fits.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/estimators/neighbors/collect.h"
#include "core/scale/automatic_options.h"
#include "core/scale/detail/interval_climb.h"
#include "core/scale/point_fits/field_curvature.h"
#include "core/scale/point_fits/height_fit.h"
#include "core/scale/point_fits/mean_normal.h"
#include "core/scale/point_fits/normal_fit.h"
#include "core/scale/point_fits/sorted_normals.h"

namespace curvd {
namespace {

// Small bodies are smaller than what the check of the nearest neighbors compares with.
constexpr uint32_t kMostNearCount = 256;
// Neighbors whose mean normal is across the plane of the heights.
constexpr size_t kNearestForPlane = 16;
// Where more than one in so many neighbors has a normal that is opposed to the plane's, they are those of both sides.
constexpr size_t kFewestPerOpposed = 8;
// Normals to which a polynomial of degree 1 is fitted.
constexpr size_t kFewestForLowDegree = 32;
// The heights tell something new if they differ by more than so many times what they err by.
constexpr double kLeastTimesError = 3.0;
// Where there is no other estimate, one that errs by more than this share of what bends by a radian within its
// neighborhood says nothing. Around an end of a body it does if it errs by no more than that share of its largest
// curvature; beside a seam, chance makes that large.
constexpr double kMostErrorTimesRadius = 0.05, kMostErrorOfLargest = 0.25;

// An estimate looks too far beyond so many radii of its largest curvature. What replaces it differs from it by this
// share of that curvature: around a pipe it can be exact.
constexpr float kMostRadii = 4.0f, kLeastOfLargest = 0.1f;

float LargestOf(const PointCurvature& point) { return std::max(std::abs(point.k1), std::abs(point.k2)); }

bool LooksTooFar(const PointCurvature& point) {
  return point.status == PointStatus::kOk && LargestOf(point) * point.radius > kMostRadii;
}

bool SaysNothing(const PointFit& fit, bool is_detail) {
  if (is_detail && fit.mean_error <= kMostErrorOfLargest * LargestOf(fit.point)) return false;
  return fit.mean_error * fit.point.radius > kMostErrorTimesRadius;
}

// The neighbors nearest to a point, for fits over one plane; short of the far side of a body, or as many as there are.
struct NearestNeighbors {
  NearestNeighbors(std::span<const NeighborNormal> neighbors, const Eigen::Vector3d& normal, bool keep_to_side)
      : frame(MeanNormal(neighbors.first(std::min(kNearestForPlane, neighbors.size())), normal)) {
    size_t opposed = 0;
    for (const NeighborNormal& neighbor : neighbors.first(std::min<size_t>(kMostNearCount, neighbors.size()))) {
      opposed += neighbor.normal.dot(frame.n) < 0.0 ? 1 : 0;
      if (keep_to_side && opposed * kFewestPerOpposed > nearest.size()) break;
      nearest.push_back(&neighbor);
    }
  }

  NormalFrame frame;
  std::vector<const NeighborNormal*> nearest;
};

// The one with the smaller error.
std::optional<PointFit> BetterOf(const std::optional<PointFit>& a, const std::optional<PointFit>& b) {
  if (!a.has_value() || !b.has_value()) return a.has_value() ? a : b;
  return b->mean_error < a->mean_error ? b : a;
}

}  // namespace

OwnFits::OwnFits(const EstimatorOptions& options, const SpatialIndex& index, const CloudChoice& choice,
                 PointCurvature* results)
    : options_(options),
      index_(index),
      results_(results),
      may_fit_normals_(IsCandidate(options, kRegressionMethod)),
      may_fit_heights_(IsCandidate(options, kQuarticMethod)) {
  for (size_t part = 0; part < choice.parts().size(); ++part) {
    const PartChoice& of = choice.parts()[part];
    is_noise_[part] = of.check.has_value() || std::any_of(of.near_checks.begin(), of.near_checks.end(),
                                                          [](const NearCheck& check) { return check.is_noise; });
    noise_[part] = of.positions_are_exact ? 0.0 : of.choice.sigma;
    uint32_t most = kMostNearCount;
    // What counts looks farther than the check.
    if (of.check.has_value()) most = std::max(most, kScaleRungs[of.check->candidate.rung + 1]);
    EstimatorOptions largest;
    most = static_cast<uint32_t>(std::min<size_t>({most, MostCount(options), index.point_count()}));
    largest.neighborhood = NeighborCount{most};
    plans_[part] = NeighborhoodPlan::Make(largest, index);
  }
}

double OwnFits::ToCaller() const { return std::ldexp(1.0, index_.scale_exponent()); }

absl::Status OwnFits::EstimateDetails(size_t group, AutomaticScratch& s) const {
  const bool may_look_too_far = MayHaveOwnFits(options_);
  AutomaticScratch::OfPoints<bool> is_marked{};  // before results change
  for (size_t i = 0; i < s.points.size; ++i) {
    const bool has_other = s.own_fits[i].has_value();  // from its side of an edge
    is_marked[i] = s.has_detail[i] || (may_look_too_far && !has_other && LooksTooFar(results_[s.points.slot[i]]));
  }
  const auto is_asked = [&](size_t i) { return is_marked[i]; };
  const auto fit = [&](size_t place, size_t i) {
    const PointCurvature& now = results_[s.points.slot[i]];
    const auto mean = now.status == PointStatus::kOk ? std::optional(now.mean / ToCaller()) : std::nullopt;
    std::optional<PointFit> found = Fit(place, i, s.pilot.normals, mean, s.has_detail[i], s);
    if (found.has_value() && !s.has_detail[i]) {
      const double difference = std::abs(found->point.mean * ToCaller() - now.mean);
      if (!(difference >= kLeastOfLargest * LargestOf(now))) found.reset();
    }
    Take(i, found, s);
  };
  return ForEach(group, is_asked, fit, s);
}

absl::Status OwnFits::EstimateWithin(size_t group, absl::FunctionRef<bool(size_t i)> is_asked,
                                     absl::FunctionRef<bool(size_t i, float radius)> reaches,
                                     AutomaticScratch& s) const {
  const auto fit = [&](size_t place, size_t i) {
    const std::span<const NeighborNormal> all(s.pilot.normals);
    size_t within = 0;
    for (const uint32_t count : kScaleRungs) {
      if (count > all.size()) break;
      // Rounded up, since it is to hold the last neighbor.
      const double radius = all[count - 1].offset.norm() / ToCaller() * (1.0 + 1e-6);
      if (reaches(i, static_cast<float>(radius))) break;
      within = count;
    }
    if (within > 0) Take(i, Fit(place, i, all.first(within), std::nullopt, false, s), s);
  };
  return ForEach(group, is_asked, fit, s);
}

absl::Status OwnFits::ForEach(size_t group, absl::FunctionRef<bool(size_t i)> is_asked,
                              absl::FunctionRef<void(size_t place, size_t i)> fit, AutomaticScratch& s) const {
  const double most_radius = ScaleOf(options_).max_radius;
  for (size_t part = 0; part < CloudChoice::kMostParts; ++part) {
    AutomaticScratch::OfPoints<size_t> kept;
    size_t kept_count = 0;
    const auto is_kept = [&](size_t i) { return i < s.points.size && s.part[i] == part && is_asked(i); };
    for (size_t i = 0; i < s.points.size; ++i) {
      if (is_kept(i)) kept[kept_count++] = i;
    }
    if (kept_count == 0) continue;
    s.pilot.RunWithin(s, WorkerScratch::kNoLimit);  // a group's points are few
    const auto visit = [&](size_t place) {
      const size_t i = kept[place];
      s.pilot.search.work += 16 * s.pilot.neighbors.count;
      double most = std::min<double>(std::numeric_limits<float>::max(), s.edge_distances[i] * ToCaller());
      if (most_radius > 0.0) most = std::min(most, most_radius * ToCaller());
      SortNormals(static_cast<float>(most), s.pilot);
      fit(place, i);
    };
    const absl::Status status = CollectNeighbors(index_, plans_[part], group, CollectedPoints::kQueries,
                                                 CollectedNormals::kInUse, s.pilot, is_kept, visit);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

std::optional<PointFit> OwnFits::Fit(size_t place, size_t i, std::span<const NeighborNormal> neighbors,
                                     std::optional<double> mean, bool is_detail, const AutomaticScratch& s) const {
  float n[3];
  s.pilot.points.normal.Get(place, n);
  const Eigen::Vector3d normal(n[0], n[1], n[2]);
  const uint32_t least_count = ScaleOf(options_).least_count;
  const NearestNeighbors near(neighbors, normal, is_detail);
  std::optional<PointFit> by_normals, by_heights;
  if (may_fit_heights_) by_heights = EstimateByHeights(near.frame, near.nearest, least_count, noise_[s.part[i]]);
  if (by_heights.has_value() && mean.has_value()) {
    const bool differs = std::abs(by_heights->point.mean - *mean) > kLeastTimesError * by_heights->mean_error;
    if (!differs) by_heights.reset();
  }
  // What polynomials leave out of exact normals is no noise, which the intervals of EstimateDetail are made of: where
  // there is an average, it stays.
  if (may_fit_normals_ && (is_noise_[s.part[i]] || !mean.has_value())) {
    by_normals = EstimateDetail(neighbors, normal, least_count, mean);
  }
  const std::optional<PointFit> best = BetterOf(by_heights, by_normals);
  if (mean.has_value()) return best;
  // A polynomial of degree 1 has the least noise, and its error tells what it smooths away.
  std::optional<PointFit> of_least_noise;
  const double radius = near.nearest.empty() ? 0.0 : near.nearest.back()->offset.norm();
  if (may_fit_normals_ && near.nearest.size() >= std::max<size_t>(kFewestForLowDegree, least_count) && radius > 0.0) {
    of_least_noise = EstimateByNormals(near.frame, near.nearest, radius, 0.0);
  }
  const std::optional<PointFit> found = BetterOf(best, of_least_noise);
  return found.has_value() && SaysNothing(*found, is_detail) ? std::nullopt : found;
}

void OwnFits::Take(size_t i, const std::optional<PointFit>& fit, AutomaticScratch& s) const {
  if (!fit.has_value()) return;
  const auto scaled = Scaled(*fit, ToCaller());
  if (!scaled.has_value()) return;
  results_[s.points.slot[i]] = scaled->point;
  s.own_fits[i] = *scaled;
}

}  // namespace curvd
