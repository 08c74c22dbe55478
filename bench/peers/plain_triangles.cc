// The strategies of Lachaud et al. 2023, section 4, that take their triangles from the neighbors themselves.
#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

#include "bench/peers/plain_estimator.h"
#include "bench/peers/plain_tensor.h"

namespace curvd::bench {
namespace {

// A number below `count`.
uint32_t Draw(std::mt19937& random, size_t count) { return static_cast<uint32_t>((uint64_t{random()} * count) >> 32); }

// Corners relative to the query.
struct Surroundings {
  const PeerCloud& cloud;
  std::span<const uint32_t> neighbors;
  Vector3d origin;

  Vector3d Offset(size_t j) const { return Triple(cloud.positions, neighbors[j]) - origin; }
  Corner At(size_t j) const { return {Offset(j), Triple(cloud.normals, neighbors[j])}; }
};

// Calls measure(surroundings, normal, sum) for each point.
template <typename Measure>
void ForEachPoint(const PeerCloud& cloud, const PeerNeighbors& neighbors, PointCurvature* out, Measure measure) {
  for (size_t i = 0; i < neighbors.size(); ++i) {
    const Surroundings around{cloud, neighbors.of(i), Triple(cloud.positions, i)};
    const Vector3d normal = BlendedNormal(cloud, i, around.neighbors);
    Measures sum;
    measure(around, normal, sum);
    out[i] = CurvatureOf(sum, normal, neighbors.radii[i]);
  }
}

// Which of the neighbors is nearest to each corner of a hexagram whose corners are at the mean neighbor distance.
std::array<size_t, 6> NearestCorners(const Surroundings& around, const Vector3d& normal) {
  const size_t count = around.neighbors.size();
  double distance = 0.0;
  for (size_t j = 0; j < count; ++j) distance += around.Offset(j).norm();
  distance /= static_cast<double>(count);
  const Frame frame = TangentFrame(normal);
  std::array<size_t, 6> nearest{};
  for (size_t s = 0; s < 6; ++s) {
    const double angle = static_cast<double>(s) * M_PI / 3.0;
    const Vector3d target = distance * (std::cos(angle) * frame.u + std::sin(angle) * frame.v);
    double least = std::numeric_limits<double>::infinity();
    for (size_t j = 0; j < count; ++j) {
      const double squared = (around.Offset(j) - target).squaredNorm();
      if (squared >= least) continue;
      least = squared;
      nearest[s] = j;
    }
  }
  return nearest;
}

}  // namespace

void RunPlainAvgHexagram(const PeerCloud& cloud, const PeerNeighbors& neighbors, PointCurvature* out) {
  for (size_t i = 0; i < neighbors.size(); ++i) {
    out[i] = PlainAvgHexagram(cloud.positions.data(), cloud.normals.data(), static_cast<uint32_t>(i),
                              neighbors.of(i).data(), neighbors.k, neighbors.radii[i], PeerWork::kPlainEstimate);
  }
}

void RunPlainHexagram(const PeerCloud& cloud, const PeerNeighbors& neighbors, PointCurvature* out) {
  ForEachPoint(cloud, neighbors, out, [](const Surroundings& around, const Vector3d& normal, Measures& sum) {
    const std::array<size_t, 6> corners = NearestCorners(around, normal);
    AddTriangle(around.At(corners[0]), around.At(corners[2]), around.At(corners[4]), sum);
    AddTriangle(around.At(corners[1]), around.At(corners[3]), around.At(corners[5]), sum);
  });
}

void RunPlainUniform(const PeerCloud& cloud, const PeerNeighbors& neighbors, size_t triangles, PointCurvature* out) {
  std::mt19937 random;
  const size_t k = neighbors.k;
  ForEachPoint(cloud, neighbors, out, [&](const Surroundings& around, const Vector3d&, Measures& sum) {
    for (size_t t = 0; t < triangles; ++t) {
      const uint32_t a = Draw(random, k);
      uint32_t b = a, c = a;
      while (b == a) b = Draw(random, k);
      while (c == a || c == b) c = Draw(random, k);
      AddTriangle(around.At(a), around.At(b), around.At(c), sum);
    }
  });
}

void RunPlainIndependent(const PeerCloud& cloud, const PeerNeighbors& neighbors, size_t triangles,
                         PointCurvature* out) {
  std::mt19937 random;
  std::vector<uint32_t> order(neighbors.k);
  ForEachPoint(cloud, neighbors, out, [&](const Surroundings& around, const Vector3d&, Measures& sum) {
    std::iota(order.begin(), order.end(), 0u);
    std::shuffle(order.begin(), order.end(), random);
    const size_t used = 3 * std::min(triangles, neighbors.k / 3);
    for (size_t j = 0; j < used; j += 3) {
      AddTriangle(around.At(order[j]), around.At(order[j + 1]), around.At(order[j + 2]), sum);
    }
  });
}

}  // namespace curvd::bench
