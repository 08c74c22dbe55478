#include "tests/core/reference_delaunay.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/estimators/delaunay/umbrella.h"
#include "tests/core/reference_estimator.h"

namespace curvd::testing {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Doubles round to 1e-15: what is nearer than kTie is equal, what is nearer than kDoubt may be either.
constexpr double kTie = 1e-12;
constexpr double kDoubt = 1e-9;
// Float distances round to 1e-7; equal ones are equal in both.
constexpr double kFloatDoubt = 1e-6;

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

struct Candidate {
  int id;
  Vector2d at;
};

double Distance(const TestPoints& points, size_t i, size_t j) {
  return (ToVector(points.positions[j]) - ToVector(points.positions[i])).norm();
}

// Whether rounding may exchange the last of the nearest `count` points with the one after it.
bool HasDoubtfulLast(const TestPoints& points, size_t i, size_t count) {
  if (count >= points.size()) return false;
  const std::vector<int> ids = NearestIds(points, i, count + 1);
  const double last = Distance(points, i, ids[count - 1]), after = Distance(points, i, ids[count]);
  return after > last && after - last < kFloatDoubt * after;
}

class BruteForce {
 public:
  BruteForce(const TestPoints& points, size_t i) : own_id_(static_cast<int>(i)) {
    const size_t count = std::min<size_t>(kUmbrellaNeighbors + 1, points.size());
    if (HasDoubtfulLast(points, i, count)) out_.certain = false;
    Vector3d axes[2];
    TangentAxes(ToVector(points.normals[i]).normalized(), axes);
    for (int id : NearestIds(points, i, count)) {
      const Vector3d offset = ToVector(points.positions[id]) - ToVector(points.positions[i]);
      // The lowest of several points at one place stands for all.
      if (offset.isZero(0.0) && id < own_id_) return;
      const Vector2d at(offset.dot(axes[0]), offset.dot(axes[1]));
      if (at.norm() > 1e-6 * offset.norm()) AddCandidate({id, at});
    }
    for (const Candidate& a : candidates_) {
      for (const Candidate& b : candidates_) {
        const double sine = Cross(a.at, b.at) / (a.at.norm() * b.at.norm());
        if (sine > kTie && IsTriangle(a, b)) out_.triangles.push_back({a.id, b.id});
        if (std::abs(sine) > kTie && std::abs(sine) < kDoubt) out_.certain = false;
      }
    }
    KeepMost();
  }

  ReferenceUmbrella Take() { return std::move(out_); }

 private:
  void AddCandidate(const Candidate& candidate) {
    for (Candidate& other : candidates_) {
      const double apart = (other.at - candidate.at).norm() / candidate.at.norm();
      if (apart > kTie && apart < kDoubt) out_.certain = false;
      if (apart > kTie) continue;
      if (candidate.id < other.id) other = candidate;
      return;
    }
    candidates_.push_back(candidate);
  }

  // Positive outside the circle through the point, a and b.
  static double OutsideCircle(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    return (la * la * Cross(b, c) + lb * lb * Cross(c, a) + lc * lc * Cross(a, b)) / (la * lb * lc * (la + lb + lc));
  }

  bool IsTriangle(const Candidate& a, const Candidate& b) {
    std::vector<Candidate> on_circle;
    bool doubtful = false;
    for (const Candidate& c : candidates_) {
      const double outside = OutsideCircle(a.at, b.at, c.at);
      if (outside < -kDoubt) return false;
      doubtful |= std::abs(outside) > kTie && std::abs(outside) < kDoubt;
      if (std::abs(outside) <= kTie) on_circle.push_back(c);
    }
    if (doubtful) {
      out_.certain = false;
      return false;
    }
    return IsFanTriangle(on_circle, a.id, b.id);
  }

  // Points on one circle with the origin make a polygon, and that a fan from its lowest id.
  bool IsFanTriangle(std::vector<Candidate>& rest, int a, int b) const {
    std::sort(rest.begin(), rest.end(), [](const Candidate& c, const Candidate& d) { return Cross(c.at, d.at) > 0.0; });
    std::vector<int> polygon = {own_id_};
    for (const Candidate& c : rest) polygon.push_back(c.id);
    const auto size = static_cast<int>(polygon.size());
    const auto lowest = static_cast<int>(std::min_element(polygon.begin(), polygon.end()) - polygon.begin());
    const std::set<int> wanted = {own_id_, a, b};
    for (int step = 1; step + 1 < size; ++step) {
      const std::set<int> triangle = {polygon[lowest], polygon[(lowest + step) % size],
                                      polygon[(lowest + step + 1) % size]};
      if (triangle == wanted) return true;
    }
    return false;
  }

  int NearestId() const {
    const auto nearest = std::min_element(candidates_.begin(), candidates_.end(),
                                          [](const auto& a, const auto& b) { return a.at.norm() < b.at.norm(); });
    int id = nearest->id;
    for (const Candidate& c : candidates_) {
      if (c.at.norm() <= nearest->at.norm() * (1.0 + kTie)) id = std::min(id, c.id);
    }
    return id;
  }

  // Of too many triangles those stay that follow the nearest neighbor; behind a gap, those before it.
  void KeepMost() {
    if (out_.triangles.size() <= Umbrella::kMaxTriangles) return;
    std::map<int, int> next, previous;
    for (const auto& [a, b] : out_.triangles) {
      next[a] = b;
      previous[b] = a;
    }
    out_.triangles.clear();
    const int nearest = NearestId();
    for (int a = nearest; next.count(a) > 0 && out_.triangles.size() < Umbrella::kMaxTriangles; a = next[a]) {
      out_.triangles.push_back({a, next[a]});
    }
    for (int b = nearest; previous.count(b) > 0 && out_.triangles.size() < Umbrella::kMaxTriangles; b = previous[b]) {
      out_.triangles.push_back({previous[b], b});
    }
  }

  const int own_id_;
  std::vector<Candidate> candidates_;
  ReferenceUmbrella out_;
};

}  // namespace

ReferenceUmbrella BruteForceUmbrella(const TestPoints& points, size_t i) { return BruteForce(points, i).Take(); }

ReferenceCurvature ReferenceDelaunay(const TestPoints& points, const std::vector<ReferenceUmbrella>& umbrellas,
                                     size_t i, const EstimatorOptions& options) {
  const auto* by_count = std::get_if<NeighborCount>(&options.neighborhood);
  const std::vector<int> ids = by_count != nullptr
                                   ? NearestIds(points, i, by_count->count)
                                   : IdsWithin(points, i, std::get<NeighborRadius>(options.neighborhood).radius);
  ReferenceCurvature result;
  result.radius = Distance(points, i, ids.back());
  result.margin = HasDoubtfulLast(points, i, ids.size()) ? 0.0 : 1.0;
  Vector3d mean_normal = Vector3d::Zero();
  for (int id : ids) mean_normal += ToVector(points.normals[id]) / static_cast<double>(ids.size());
  const double w = options.average_normal_weight;
  Vector3d axes[2];
  TangentAxes(((1.0 - w) * ToVector(points.normals[i]) + w * mean_normal).normalized(), axes);

  const std::set<int> neighbors(ids.begin(), ids.end());
  const auto corner = [&](int id) {
    return ReferenceCorner{ToVector(points.positions[id]) - ToVector(points.positions[i]),
                           ToVector(points.normals[id])};
  };
  ReferenceMeasures sum;
  for (int id : ids) {
    if (!umbrellas[id].certain) result.margin = 0.0;
    for (const auto& [a, b] : umbrellas[id].triangles) {
      if (neighbors.count(a) == 0 || neighbors.count(b) == 0) continue;
      double weight = 0.0;
      for (int c : {id, a, b}) {
        const double part = Distance(points, i, c) / result.radius;
        weight += (options.even_weights ? 1.0 : 1.0 - part * part) / 3.0;
      }
      const double before = sum.area;
      sum.AddTriangle(corner(id), corner(a), corner(b), axes, weight / 3.0);
      // A triangle seen edge on: float rounding may turn it either way.
      const double edges = Distance(points, id, a) * Distance(points, id, b);
      if (sum.area - before < 1e-5 * edges * weight) result.margin = 0.0;
    }
  }
  result.estimated = sum.area > 1e-4 * result.radius * result.radius;
  sum.ToCurvature(result);
  if (!options.even_weights) {
    // Back to what the tilt of the triangles takes from the tensor.
    const double half_difference = 0.5 * (result.k2 - result.k1);
    const double squares = 3.0 * result.mean * result.mean + half_difference * half_difference;
    const double stretched = half_difference * (1.0 + std::min(result.radius * result.radius / 6.0 * squares, 0.25));
    result.k1 = result.mean - stretched;
    result.k2 = result.mean + stretched;
  }
  return result;
}

}  // namespace curvd::testing
