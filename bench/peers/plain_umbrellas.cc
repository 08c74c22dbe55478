#include <algorithm>
#include <limits>

#include "bench/peers/plain_tensor.h"

namespace curvd::bench {
namespace {

struct PlanePoint {
  double x, y;  // inverted: the projected offset over its squared length
  uint32_t index;
};

double Turn(const PlanePoint& a, const PlanePoint& b, const PlanePoint& c) {
  return (b.x - a.x) * (c.y - b.y) - (b.y - a.y) * (c.x - b.x);
}

// Triangles of one point: itself, second, third.
struct UmbrellaTriangle {
  uint32_t second, third;
};

struct Umbrellas {
  std::vector<size_t> first;  // of each point's triangles; one more element than points
  std::vector<UmbrellaTriangle> triangles;
};

// Lower and upper hull by monotone chain: the points on the convex hull of the inverted points are the Delaunay
// neighbors of the origin, and hull edges its triangles, save those that see the origin from outside.
void AddUmbrella(std::vector<PlanePoint>& points, Umbrellas& out) {
  std::sort(points.begin(), points.end(),
            [](const PlanePoint& a, const PlanePoint& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  std::vector<PlanePoint> hull;
  for (int side = 0; side < 2; ++side) {
    const size_t start = hull.size();
    for (const PlanePoint& point : points) {
      while (hull.size() >= start + 2 && Turn(hull[hull.size() - 2], hull.back(), point) <= 0.0) hull.pop_back();
      hull.push_back(point);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  for (size_t i = 0; i < hull.size(); ++i) {
    const PlanePoint &a = hull[i], &b = hull[(i + 1) % hull.size()];
    if (a.x * b.y - a.y * b.x > 0.0) out.triangles.push_back({a.index, b.index});
  }
}

Umbrellas BuildUmbrellas(const PeerCloud& cloud, size_t umbrella_size) {
  const size_t size = std::min(umbrella_size, cloud.size());
  const PeerNeighbors nearest = FindPeerNeighbors(cloud, size, cloud.size());
  Umbrellas umbrellas;
  std::vector<PlanePoint> points;
  for (uint32_t i = 0; i < cloud.size(); ++i) {
    umbrellas.first.push_back(umbrellas.triangles.size());
    const Vector3d origin = Triple(cloud.positions, i);
    const Frame frame = TangentFrame(Triple(cloud.normals, i));
    points.clear();
    for (uint32_t j : nearest.of(i)) {
      const Vector3d offset = Triple(cloud.positions, j) - origin;
      const double x = offset.dot(frame.u), y = offset.dot(frame.v), squared = x * x + y * y;
      if (squared > 0.0) points.push_back({x / squared, y / squared, j});
    }
    if (points.size() > 2) AddUmbrella(points, umbrellas);
  }
  umbrellas.first.push_back(umbrellas.triangles.size());
  return umbrellas;
}

}  // namespace

void RunPlainUmbrellas(const PeerCloud& cloud, const PeerNeighbors& neighbors, size_t umbrella_size,
                       PointCurvature* out) {
  const Umbrellas umbrellas = BuildUmbrellas(cloud, umbrella_size);
  constexpr uint32_t kNobody = std::numeric_limits<uint32_t>::max();
  std::vector<uint32_t> member_of(cloud.size(), kNobody);  // whose neighborhood a point was last seen in
  for (uint32_t i = 0; i < neighbors.size(); ++i) {
    const Vector3d origin = Triple(cloud.positions, i);
    for (uint32_t j : neighbors.of(i)) member_of[j] = i;
    const auto corner = [&](uint32_t j) {
      return Corner{Triple(cloud.positions, j) - origin, Triple(cloud.normals, j)};
    };
    Measures sum;
    for (uint32_t j : neighbors.of(i)) {
      for (size_t t = umbrellas.first[j]; t < umbrellas.first[j + 1]; ++t) {
        const UmbrellaTriangle& triangle = umbrellas.triangles[t];
        if (member_of[triangle.second] != i || member_of[triangle.third] != i) continue;
        AddTriangle(corner(j), corner(triangle.second), corner(triangle.third), sum);
      }
    }
    out[i] = CurvatureOf(sum, BlendedNormal(cloud, i, neighbors.of(i)), neighbors.radii[i]);
  }
}

}  // namespace curvd::bench
