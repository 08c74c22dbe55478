#include "client/orient/orient_normals.h"

#include <algorithm>
#include <cmath>

#include "client/neighbors/kd_tree.h"
#include "client/orient/parity_sets.h"

namespace curv {
namespace {

// Neighbors that a point's normal may be compared with.
constexpr int kNeighbors = 12;
// The share of the area that the normals of a closed surface add up to, holes and all, stays below this.
constexpr double kClosedShare = 0.25;

struct Edge {
  float cost;  // 0: certain
  uint32_t a;
  uint32_t b;
  bool opposite;
};

bool IsFinite(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// The points that can be oriented, without the others.
struct Cloud {
  std::vector<size_t> indices;
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;  // unit
  std::vector<double> areas;  // of the surface around each, but for a common factor
};

Cloud UsablePoints(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals) {
  Cloud cloud;
  for (size_t i = 0; i < positions.size(); ++i) {
    const double length = Norm(normals[i]);
    if (!IsFinite(positions[i]) || !std::isfinite(length) || length == 0.0) continue;
    cloud.indices.push_back(i);
    cloud.positions.push_back(positions[i]);
    cloud.normals.push_back((1.0 / length) * normals[i]);
  }
  cloud.areas.resize(cloud.positions.size());
  return cloud;
}

// Going around a bend, the normal is mirrored in the plane between the two points: exactly so on a circle, and also
// around an edge. Ways across the surface cost more than ways along it: in a noisy cloud they say nothing.
Edge Compare(const Cloud& cloud, uint32_t a, const Neighbor& neighbor) {
  const uint32_t b = neighbor.index;
  if (neighbor.squared_distance == 0.0) {
    const double agreement = Dot(cloud.normals[a], cloud.normals[b]);
    return {static_cast<float>(1.0 - std::abs(agreement)), a, b, agreement < 0.0};
  }
  const Vec3 way = (1.0 / std::sqrt(neighbor.squared_distance)) * (cloud.positions[b] - cloud.positions[a]);
  const double across_a = Dot(way, cloud.normals[a]), across_b = Dot(way, cloud.normals[b]);
  const double agreement = Dot(cloud.normals[a] - 2.0 * across_a * way, cloud.normals[b]);
  const double cost = 1.0 - std::abs(agreement) + std::abs(across_a) + std::abs(across_b);
  return {static_cast<float>(cost), a, b, agreement < 0.0};
}

std::vector<Edge> CompareNeighbors(Cloud& cloud) {
  std::vector<Edge> edges;
  edges.reserve(cloud.positions.size() * kNeighbors);
  KdTree(cloud.positions).ForEach(kNeighbors, [&](uint32_t a, std::span<const Neighbor> neighbors) {
    for (const Neighbor& neighbor : neighbors) edges.push_back(Compare(cloud, a, neighbor));
    if (!neighbors.empty()) cloud.areas[a] = neighbors[neighbors.size() / 2].squared_distance;
  });
  return edges;
}

// What decides about the sign of a whole piece.
struct Piece {
  double area = 0.0;
  double kept = 0.0;  // area whose given normals agree with the root's
  Vec3 center;        // times area
  Vec3 normal_sum;    // in the root's orientation, times area
  double flux = 0.0;
};

// Whether the piece's normals have to be negated, all of them, once they agree with the root.
bool PointsInward(const Piece& piece) {
  if (Norm(piece.normal_sum) > kClosedShare * piece.area) return piece.kept < 0.5 * piece.area;
  // By the divergence theorem, the flux of the position is three times the volume inside. Taken about the center, so
  // that holes matter less.
  const Vec3 center = (1.0 / piece.area) * piece.center;
  return piece.flux - Dot(center, piece.normal_sum) < 0.0;
}

}  // namespace

Orientation OrientNormals(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals) {
  Orientation orientation;
  orientation.flip.resize(positions.size());
  Cloud cloud = UsablePoints(positions, normals);
  std::vector<Edge> edges = CompareNeighbors(cloud);
  std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
    return x.cost != y.cost ? x.cost < y.cost : x.a != y.a ? x.a < y.a : x.b < y.b;
  });
  ParitySets sets(cloud.positions.size());
  for (const Edge& edge : edges) sets.Join(edge.a, edge.b, edge.opposite);

  std::vector<Piece> pieces(cloud.positions.size());  // at the index of their root
  for (uint32_t i = 0; i < cloud.positions.size(); ++i) {
    const auto [root, opposite] = sets.Find(i);
    Piece& piece = pieces[root];
    const Vec3 normal = (opposite ? -cloud.areas[i] : cloud.areas[i]) * cloud.normals[i];
    piece.area += cloud.areas[i];
    piece.kept += opposite ? 0.0 : cloud.areas[i];
    piece.center += cloud.areas[i] * cloud.positions[i];
    piece.normal_sum += normal;
    piece.flux += Dot(normal, cloud.positions[i]);
    orientation.pieces += root == i ? 1 : 0;
  }
  for (uint32_t i = 0; i < cloud.positions.size(); ++i) {
    const auto [root, opposite] = sets.Find(i);
    const bool flip = opposite != PointsInward(pieces[root]);
    orientation.flip[cloud.indices[i]] = flip ? 1 : 0;
    orientation.flipped += flip ? 1 : 0;
  }
  return orientation;
}

}  // namespace curv
