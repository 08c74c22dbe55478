#include "client/orient/orient_normals.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "client/neighbors/nearest_neighbors.h"
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

// The order in which edges are trusted. It is total, so that the tree does not depend on how neighbors are found.
bool CostsLess(const Edge& x, const Edge& y) {
  return x.cost != y.cost ? x.cost < y.cost : x.a != y.a ? x.a < y.a : x.b < y.b;
}

bool IsFinite(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// The points that can be oriented, without the others.
struct Cloud {
  std::vector<uint32_t> indices;  // of the points among all that were given
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;  // unit
  std::vector<double> areas;  // of the surface around each point, but for a common factor
};

Cloud UsablePoints(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals) {
  Cloud cloud;
  for (uint32_t i = 0; i < positions.size(); ++i) {
    const double length = Norm(normals[i]);
    if (!IsFinite(positions[i]) || !std::isfinite(length) || length == 0.0) continue;
    cloud.indices.push_back(i);
    cloud.positions.push_back(positions[i]);
    cloud.normals.push_back((1.0 / length) * normals[i]);
  }
  cloud.areas.resize(cloud.positions.size());
  return cloud;
}

Edge MakeEdge(double cost, uint32_t a, uint32_t b, double agreement) {
  // Positions so far apart that their difference overflows say nothing about each other.
  constexpr float kWorst = 4.0f;
  return {std::isfinite(cost) ? static_cast<float>(cost) : kWorst, a, b, agreement < 0.0};
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

// Joins points along the edges in the order of their costs: Kruskal's minimum spanning tree. Edges are sorted a part at
// a time, because those of the lowest costs join nearly all points, and edges within a set need not be sorted.
ParitySets JoinPoints(Cloud& cloud, int threads) {
  std::vector<Edge> edges = CompareNeighbors(cloud, threads);
  ParitySets sets(cloud.positions.size());
  const size_t part = std::max<size_t>(1, 2 * cloud.positions.size());
  for (auto first = edges.begin(), last = edges.end(); first != last;) {
    const auto end = first + std::min(static_cast<ptrdiff_t>(part), last - first);
    if (end != last) std::nth_element(first, end, last, CostsLess);
    std::sort(first, end, CostsLess);
    for (; first != end; ++first) sets.Join(first->a, first->b, first->opposite);
    sets.Flatten();
    last = std::remove_if(first, last, [&sets](const Edge& e) { return sets.Find(e.a).root == sets.Find(e.b).root; });
  }
  return sets;
}

// Sums over a piece of the surface, which decide about the sign of all its normals.
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
  for (uint32_t i = 0; i < cloud.positions.size(); ++i) {
    const auto [root, opposite] = sets.Find(i);
    Piece& piece = sums.pieces[sums.at[root]];
    const Vec3 normal = (opposite ? -cloud.areas[i] : cloud.areas[i]) * cloud.normals[i];
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
