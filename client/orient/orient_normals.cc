#include "client/orient/orient_normals.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <span>

#include "client/neighbors/nearest_neighbors.h"
#include "client/neighbors/scaled_positions.h"
#include "client/neighbors/spatial_order.h"
#include "client/orient/parity_sets.h"

namespace curv {
namespace {

// Neighbors that a point's normal may be compared with.
constexpr int kNeighbors = 12;
// The share of the area that the normals of a closed surface add up to, holes and all, stays below this.
constexpr double kClosedShare = 0.25;

// Says how sure the normals of two neighbors can be compared, and what the comparison says.
struct Edge {
  float cost;  // 0: certain
  uint32_t a;
  uint32_t b : 31;
  uint32_t opposite : 1;  // whether the normals point to different sides of the surface
};

bool IsFinite(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// The points that can be oriented, without the others, in an order in which neighbors are close in memory.
struct Cloud {
  std::vector<uint32_t> places;   // of the points in the order in which they were given
  std::vector<uint32_t> indices;  // of the points among all that were given
  std::vector<Vec3> positions;    // times a power of two, so that squares of distances do not overflow
  std::vector<Vec3> normals;      // unit
  std::vector<double> areas;      // of the surface around each point, but for a common factor
};

Cloud UsablePoints(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals) {
  std::vector<uint32_t> usable;
  std::vector<Vec3> usable_positions;
  for (uint32_t i = 0; i < positions.size(); ++i) {
    const double length = Norm(normals[i]);
    if (!IsFinite(positions[i]) || !std::isfinite(length) || length == 0.0) continue;
    usable.push_back(i);
    usable_positions.push_back(positions[i]);
  }
  ScaleToUnit(usable_positions);
  const std::vector<uint32_t> order = SpatialOrder(usable_positions);
  Cloud cloud;
  cloud.places.resize(order.size());
  cloud.areas.resize(order.size());
  for (const uint32_t i : order) {
    cloud.places[i] = static_cast<uint32_t>(cloud.indices.size());
    cloud.indices.push_back(usable[i]);
    cloud.positions.push_back(usable_positions[i]);
    cloud.normals.push_back((1.0 / Norm(normals[usable[i]])) * normals[usable[i]]);
  }
  return cloud;
}

Edge MakeEdge(double cost, uint32_t a, uint32_t b, double agreement) {
  return {static_cast<float>(cost), a, b, agreement < 0.0};
}

// Going around a bend, the normal is mirrored in the plane between the two points: exactly so on a circle, and also
// around an edge. Ways across the surface cost more than ways along it: in a noisy cloud they say nothing.
Edge Compare(const Cloud& cloud, uint32_t a, const Neighbor& neighbor) {
  const uint32_t b = neighbor.index;
  if (neighbor.squared_distance == 0.0) {
    const double agreement = Dot(cloud.normals[a], cloud.normals[b]);
    return MakeEdge(1.0 - std::abs(agreement), a, b, agreement);
  }
  const Vec3 way = (1.0 / std::sqrt(neighbor.squared_distance)) * (cloud.positions[b] - cloud.positions[a]);
  const double across_a = Dot(way, cloud.normals[a]), across_b = Dot(way, cloud.normals[b]);
  const double agreement = Dot(cloud.normals[a] - 2.0 * across_a * way, cloud.normals[b]);
  return MakeEdge(1.0 - std::abs(agreement) + std::abs(across_a) + std::abs(across_b), a, b, agreement);
}

// Compares each point with its neighbors, and measures the area around it.
std::vector<Edge> CompareNeighbors(Cloud& cloud, int threads) {
  const size_t points = cloud.positions.size();
  if (points < 2) return {};
  const size_t count = std::min<size_t>(kNeighbors, points - 1);
  std::vector<Edge> edges(points * count);  // those of point a from a * count on
  ForEachNeighborhood(cloud.positions, kNeighbors, threads, [&](uint32_t a, std::span<const Neighbor> neighbors) {
    for (size_t i = 0; i < count; ++i) edges[a * count + i] = Compare(cloud, a, neighbors[i]);
    cloud.areas[a] = neighbors[count / 2].squared_distance;
  });
  return edges;
}

// Moves the cheaper edges out, about `count` of them and at least one. The others keep their order.
std::vector<Edge> TakeCheapest(size_t count, std::vector<Edge>& edges) {
  constexpr size_t kSamples = 1000;
  std::vector<float> costs;
  for (size_t i = 0; i < edges.size(); i += edges.size() / kSamples + 1) costs.push_back(edges[i].cost);
  std::sort(costs.begin(), costs.end());
  const size_t rank = costs.size() * std::min(count, edges.size()) / edges.size();
  const float limit = costs[std::min(rank, costs.size() - 1)];
  std::vector<Edge> cheapest;
  std::copy_if(edges.begin(), edges.end(), std::back_inserter(cheapest),
               [&](const Edge& e) { return e.cost <= limit; });
  std::erase_if(edges, [&](const Edge& e) { return e.cost <= limit; });
  return cheapest;
}

// Joins points along the edges in the order of their costs: Kruskal's minimum spanning tree. Edges are sorted a part at
// a time, because those of the lowest costs join nearly all points, and edges within a set need not be sorted.
ParitySets JoinPoints(Cloud& cloud, int threads) {
  // Total, so that the tree does not depend on the order of the points in memory.
  const auto costs_less = [&indices = cloud.indices](const Edge& x, const Edge& y) {
    return x.cost != y.cost ? x.cost < y.cost : x.a != y.a ? indices[x.a] < indices[y.a] : indices[x.b] < indices[y.b];
  };
  std::vector<Edge> edges = CompareNeighbors(cloud, threads);
  ParitySets sets(cloud.positions.size());
  while (!edges.empty()) {
    std::vector<Edge> cheapest = TakeCheapest(cloud.positions.size(), edges);
    std::sort(cheapest.begin(), cheapest.end(), costs_less);
    for (const Edge& edge : cheapest) sets.Join(edge.a, edge.b, edge.opposite);
    sets.Flatten();
    std::erase_if(edges, [&sets](const Edge& e) { return sets.Find(e.a).root == sets.Find(e.b).root; });
  }
  return sets;
}

// Sums over a piece of the surface, which decide about the sign of all its normals.
struct Piece {
  size_t points = 0;
  size_t kept_points = 0;  // whose given normals agree with the root's
  double area = 0.0;
  double kept = 0.0;  // area of those
  Vec3 center;        // times area
  Vec3 normal_sum;    // in the root's orientation, times area
  double flux = 0.0;
};

// Whether the piece's normals have to be negated, all of them, once they agree with the root.
bool PointsInward(const Piece& piece) {
  // Points at one place have no area.
  if (piece.area == 0.0) return 2 * piece.kept_points < piece.points;
  if (Norm(piece.normal_sum) > kClosedShare * piece.area) return piece.kept < 0.5 * piece.area;
  // By the divergence theorem, the flux of the position is three times the volume inside. Taken about the center, so
  // that holes matter less.
  const Vec3 center = (1.0 / piece.area) * piece.center;
  return piece.flux - Dot(center, piece.normal_sum) < 0.0;
}

// The pieces of a cloud, and the piece of each root.
struct Pieces {
  std::vector<Piece> pieces;
  std::vector<uint32_t> at;  // index of a root's piece
};

Pieces SumPieces(const Cloud& cloud, const ParitySets& sets) {
  Pieces sums{.pieces = {}, .at = std::vector<uint32_t>(cloud.positions.size())};
  for (uint32_t i = 0; i < cloud.positions.size(); ++i) {
    if (sets.Find(i).root != i) continue;
    sums.at[i] = static_cast<uint32_t>(sums.pieces.size());
    sums.pieces.emplace_back();
  }
  // In the given order, which rounding depends on.
  for (const uint32_t i : cloud.places) {
    const auto [root, opposite] = sets.Find(i);
    Piece& piece = sums.pieces[sums.at[root]];
    const Vec3 normal = (opposite ? -cloud.areas[i] : cloud.areas[i]) * cloud.normals[i];
    piece.points += 1;
    piece.kept_points += opposite ? 0 : 1;
    piece.area += cloud.areas[i];
    piece.kept += opposite ? 0.0 : cloud.areas[i];
    piece.center += cloud.areas[i] * cloud.positions[i];
    piece.normal_sum += normal;
    piece.flux += Dot(normal, cloud.positions[i]);
  }
  return sums;
}

}  // namespace

Orientation OrientNormals(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals, int threads) {
  Cloud cloud = UsablePoints(positions, normals);
  const ParitySets sets = JoinPoints(cloud, threads);
  const Pieces sums = SumPieces(cloud, sets);
  Orientation orientation;
  orientation.flip.resize(positions.size());
  orientation.pieces = sums.pieces.size();
  for (uint32_t i = 0; i < cloud.positions.size(); ++i) {
    const auto [root, opposite] = sets.Find(i);
    const bool flip = opposite != PointsInward(sums.pieces[sums.at[root]]);
    orientation.flip[cloud.indices[i]] = flip ? 1 : 0;
    orientation.flipped += flip ? 1 : 0;
  }
  return orientation;
}

}  // namespace curv
