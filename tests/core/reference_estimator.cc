#include "tests/core/reference_estimator.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

#include "tests/core/reference_fits.h"

namespace curvd::testing {
namespace {

using Eigen::Vector3d;

// Averages over the six sectors around targets at angle + s * 60 degrees; lowers `margin` to the angular distance of
// the nearest neighbor to a sector's bound.
std::array<ReferenceCorner, 6> SectorAverages(const TestPoints& points, size_t i, const std::vector<int>& ids,
                                              const Vector3d axes[2], double angle, double& margin) {
  std::array<ReferenceCorner, 6> corners;
  std::array<int, 6> counts{};
  corners.fill({Vector3d::Zero(), Vector3d::Zero()});
  const Vector3d query = ToVector(points.positions[i]);
  for (int id : ids) {
    const Vector3d offset = ToVector(points.positions[id]) - query;
    const double x = offset.dot(axes[0]), y = offset.dot(axes[1]);
    if (x == 0 && y == 0) continue;
    const double turns = (std::atan2(y, x) - angle) / (std::numbers::pi / 3.0) + 0.5;
    margin = std::min(margin, std::abs(turns - std::round(turns)));
    const int s = ((static_cast<int>(std::floor(turns)) % 6) + 6) % 6;
    corners[s].position += offset;
    corners[s].normal += ToVector(points.normals[id]);
    ++counts[s];
  }
  for (int s = 0; s < 6; ++s) {
    if (counts[s] == 0) {
      corners[s] = {Vector3d::Zero(), ToVector(points.normals[i])};
    } else {
      corners[s].position /= counts[s];
      corners[s].normal.normalize();
    }
  }
  return corners;
}

std::array<ReferenceCorner, 6> NearestToTargets(const TestPoints& points, size_t i, const Vector3d axes[2], double rho,
                                                double& margin) {
  std::array<ReferenceCorner, 6> corners;
  const Vector3d query = ToVector(points.positions[i]);
  for (int s = 0; s < 6; ++s) {
    const double angle = s * std::numbers::pi / 3.0;
    const Vector3d target = query + rho * (std::cos(angle) * axes[0] + std::sin(angle) * axes[1]);
    double best = std::numeric_limits<double>::infinity(), second = best;
    size_t nearest = 0;
    for (size_t id = 0; id < points.size(); ++id) {
      const double distance = (ToVector(points.positions[id]) - target).norm();
      if (distance < best) {
        second = std::exchange(best, distance);
        nearest = id;
      } else {
        second = std::min(second, distance);
      }
    }
    margin = std::min(margin, (second - best) / rho);
    corners[s] = {ToVector(points.positions[nearest]) - query, ToVector(points.normals[nearest])};
  }
  return corners;
}

struct Ranked {
  double distance;
  int id;
  auto operator<=>(const Ranked&) const = default;
};

std::vector<Ranked> RankAll(const TestPoints& points, size_t i) {
  std::vector<Ranked> ranked(points.size());
  const Vector3d query = ToVector(points.positions[i]);
  for (size_t j = 0; j < points.size(); ++j) {
    ranked[j] = {(ToVector(points.positions[j]) - query).norm(), static_cast<int>(j)};
  }
  std::sort(ranked.begin(), ranked.end());
  return ranked;
}

std::vector<int> Ids(const std::vector<Ranked>& ranked, size_t count) {
  std::vector<int> ids(count);
  for (size_t j = 0; j < count; ++j) ids[j] = ranked[j].id;
  return ids;
}

// The direction between the point's own normal and the mean of its neighbors'.
Vector3d BlendedNormal(const TestPoints& points, size_t i, const std::vector<int>& ids,
                       const EstimatorOptions& options) {
  Vector3d mean_normal = Vector3d::Zero();
  for (int id : ids) mean_normal += ToVector(points.normals[id]);
  mean_normal /= static_cast<double>(ids.size());
  const double w = options.average_normal_weight;
  return ((1.0 - w) * ToVector(points.normals[i]) + w * mean_normal).normalized();
}

// Avg-hexagram or hexagram, from a neighborhood whose radius and margin are already in `result`.
void EstimateByHexagrams(const TestPoints& points, size_t i, const std::vector<int>& ids,
                         const EstimatorOptions& options, ReferenceCurvature& result) {
  const bool hexagram = options.estimator == "hexagram";
  Vector3d axes[2];
  TangentAxes(BlendedNormal(points, i, ids, options), axes);

  ReferenceMeasures sum;
  const uint32_t rotations = hexagram ? 1 : options.rotation_count;
  for (uint32_t r = 0; r < rotations; ++r) {
    const double angle = std::numbers::pi / 3.0 * r / rotations;
    const auto corners = hexagram ? NearestToTargets(points, i, axes, result.radius * 2.0 / 3.0, result.margin)
                                  : SectorAverages(points, i, ids, axes, angle, result.margin);
    sum.AddTriangle(corners[0], corners[2], corners[4], axes);
    sum.AddTriangle(corners[1], corners[3], corners[5], axes);
  }
  result.estimated = sum.area > 1e-4 * result.radius * result.radius;
  sum.ToCurvature(result);
}

// A fitted surface, whose shape operator says everything.
void EstimateByFit(const TestPoints& points, size_t i, const std::vector<int>& ids, const EstimatorOptions& options,
                   ReferenceCurvature& result) {
  const ReferenceNeighborhood neighborhood = NeighborhoodOf(points, i, ids);
  std::optional<Eigen::Matrix2d> shape;
  if (options.estimator == "jet") {
    shape = JetShapeOperator(neighborhood, static_cast<int>(options.jet_degree));
  } else if (options.estimator == "aso") {
    shape = AlgebraicShapeOperator(neighborhood, result.radius, options.project);
  } else if (options.regression_degree == 1) {
    shape = LinearRegressionOperator(neighborhood);
  } else {
    shape = NormalRegressionOperator(neighborhood, result.radius, BlendedNormal(points, i, ids, options),
                                     static_cast<int>(options.regression_degree));
  }
  if (!shape.has_value()) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(*shape, Eigen::EigenvaluesOnly);
  result.estimated = true;
  result.k1 = solver.eigenvalues()[0];
  result.k2 = solver.eigenvalues()[1];
  result.mean = 0.5 * (result.k1 + result.k2);
  result.gaussian = result.k1 * result.k2;
}

}  // namespace

std::vector<int> NearestIds(const TestPoints& points, size_t i, size_t k) { return Ids(RankAll(points, i), k); }

std::vector<int> IdsWithin(const TestPoints& points, size_t i, double radius) {
  const std::vector<Ranked> ranked = RankAll(points, i);
  size_t count = 0;
  while (count < ranked.size() && ranked[count].distance <= radius) ++count;
  return Ids(ranked, count);
}

ReferenceCurvature ReferenceEstimate(const TestPoints& points, size_t i, const EstimatorOptions& options) {
  const bool hexagram = options.estimator == "hexagram";
  const std::vector<Ranked> ranked = RankAll(points, i);
  const auto* by_count = std::get_if<NeighborCount>(&options.neighborhood);
  size_t searched;
  if (by_count != nullptr) {
    searched = hexagram ? std::min<size_t>(by_count->count, 48) : by_count->count;
  } else {
    searched = IdsWithin(points, i, std::get<NeighborRadius>(options.neighborhood).radius).size();
  }
  ReferenceCurvature result;
  const double searched_radius = ranked[searched - 1].distance;
  result.margin = searched < ranked.size() ? ranked[searched].distance / searched_radius - 1.0 : 1.0;
  const double factor = by_count != nullptr ? std::sqrt(static_cast<double>(by_count->count) / searched) : 1.0;
  result.radius = searched_radius * factor;
  const std::vector<int> ids = Ids(ranked, searched);
  if (hexagram || options.estimator == "avg-hexagram") {
    EstimateByHexagrams(points, i, ids, options, result);
  } else {
    EstimateByFit(points, i, ids, options, result);
  }
  return result;
}

}  // namespace curvd::testing
