#include "tests/core/reference_estimator.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace curvd::testing {
namespace {

using Eigen::Vector3d;

Vector3d ToVector(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

struct Corner {
  Vector3d position;
  Vector3d normal;
};

struct Measures {
  double area = 0, mean = 0, gaussian = 0;
  Eigen::Matrix2d tensor = Eigen::Matrix2d::Zero();
};

// Lachaud et al. 2023, Property 1, with 1/4 in the mean measure.
void AddTriangle(const Corner& a, const Corner& b, const Corner& c, const Vector3d axes[2], Measures& sum) {
  const Vector3d w = (a.normal + b.normal + c.normal) / 3.0;
  const Vector3d e1 = b.position - a.position, e2 = c.position - a.position;
  const double area = 0.5 * w.dot(e1.cross(e2));
  const double turn = area < 0 ? -1.0 : 1.0;
  sum.area += turn * area;
  sum.mean += turn * 0.25 *
              w.dot((c.normal - b.normal).cross(a.position) + (a.normal - c.normal).cross(b.position) +
                    (b.normal - a.normal).cross(c.position));
  sum.gaussian += turn * 0.5 * a.normal.dot(b.normal.cross(c.normal));
  for (int x = 0; x < 2; ++x) {
    for (int y = 0; y < 2; ++y) {
      sum.tensor(x, y) += turn * 0.5 *
                          w.dot(axes[y].dot(b.normal - a.normal) * axes[x].cross(e2) -
                                axes[y].dot(c.normal - a.normal) * axes[x].cross(e1));
    }
  }
}

// The figure's tangent axes for a unit normal.
void TangentAxes(const Vector3d& n, Vector3d axes[2]) {
  int largest = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (std::abs(n[axis]) > std::abs(n[largest])) largest = axis;
  }
  axes[0] = n.cross(Vector3d::Unit((largest + 1) % 3)).normalized();
  axes[1] = n.cross(axes[0]);
}

// Averages over the six sectors around targets at angle + s * 60 degrees; lowers `margin` to the angular distance of
// the nearest neighbor to a sector's bound.
std::array<Corner, 6> SectorAverages(const TestPoints& points, size_t i, const std::vector<int>& ids,
                                     const Vector3d axes[2], double angle, double& margin) {
  std::array<Corner, 6> corners;
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

std::array<Corner, 6> NearestToTargets(const TestPoints& points, size_t i, const Vector3d axes[2], double rho,
                                       double& margin) {
  std::array<Corner, 6> corners;
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

}  // namespace

std::vector<int> NearestIds(const TestPoints& points, size_t i, size_t k) { return Ids(RankAll(points, i), k); }

std::vector<int> IdsWithin(const TestPoints& points, size_t i, double radius) {
  const std::vector<Ranked> ranked = RankAll(points, i);
  size_t count = 0;
  while (count < ranked.size() && ranked[count].distance <= radius) ++count;
  return Ids(ranked, count);
}

ReferenceCurvature ReferenceEstimate(const TestPoints& points, size_t i, const EstimatorOptions& options) {
  const bool hexagram = options.estimator == EstimatorKind::kHexagram;
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

  Vector3d mean_normal = Vector3d::Zero();
  for (int id : ids) mean_normal += ToVector(points.normals[id]);
  mean_normal /= static_cast<double>(ids.size());
  const double w = options.average_normal_weight;
  const Vector3d n = ((1.0 - w) * ToVector(points.normals[i]) + w * mean_normal).normalized();
  Vector3d axes[2];
  TangentAxes(n, axes);

  Measures sum;
  const uint32_t rotations = hexagram ? 1 : options.rotation_count;
  for (uint32_t r = 0; r < rotations; ++r) {
    const double angle = std::numbers::pi / 3.0 * r / rotations;
    const auto corners = hexagram ? NearestToTargets(points, i, axes, result.radius * 2.0 / 3.0, result.margin)
                                  : SectorAverages(points, i, ids, axes, angle, result.margin);
    AddTriangle(corners[0], corners[2], corners[4], axes, sum);
    AddTriangle(corners[1], corners[3], corners[5], axes, sum);
  }
  result.estimated = sum.area > 1e-4 * result.radius * result.radius;
  result.mean = sum.mean / sum.area;
  result.gaussian = sum.gaussian / sum.area;
  const Eigen::Matrix2d tensor = 0.5 / sum.area * (sum.tensor + sum.tensor.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(tensor, Eigen::EigenvaluesOnly);
  const double half_difference = 0.5 * (solver.eigenvalues()[1] - solver.eigenvalues()[0]);
  result.k1 = result.mean - half_difference;
  result.k2 = result.mean + half_difference;
  return result;
}

}  // namespace curvd::testing
