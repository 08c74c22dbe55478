#include <cmath>
#include <cstdint>
#include <vector>

#include "bench/peers/heap_result_set.h"
#include "bench/peers/morton_order.h"
#include "bench/peers/packed_points.h"
#include "bench/peers/peers.h"
#include "bench/peers/plain_estimator.h"
#include "bench/peers/sampled_queries.h"
#include "bench/stopwatch.h"

namespace curvd::bench {
namespace {

std::vector<float> Reordered(std::span<const float> triples, const std::vector<uint32_t>& order) {
  std::vector<float> result(triples.size());
  for (size_t i = 0; i < order.size(); ++i) {
    for (size_t axis = 0; axis < 3; ++axis) result[3 * i + axis] = triples[3 * size_t{order[i]} + axis];
  }
  return result;
}

}  // namespace

PeerCost RunStrongestPeer(std::span<const float> positions, std::span<const float> normals, size_t k, PeerWork work,
                          PointCurvature* out, size_t one_in) {
  const double start = CpuSeconds();
  const std::vector<uint32_t> order = MortonOrder(positions);
  const std::vector<float> sorted_positions = Reordered(positions, order);
  std::vector<float> sorted_normals;
  if (work != PeerWork::kSearch) sorted_normals = Reordered(normals, order);
  const PackedPoints<float> points{sorted_positions.data(), order.size()};
  NanoflannTree<float> tree(3, points, nanoflann::KDTreeSingleIndexAdaptorParams(32));
  tree.buildIndex();
  const double built = CpuSeconds();
  HeapResultSet nearest(k);
  const double query = AnswerQueries(points.count, one_in, [&](uint32_t i) {
    nearest.Clear();
    tree.findNeighbors(nearest, &sorted_positions[3 * size_t{i}], nanoflann::SearchParams());
    const double radius = std::sqrt(static_cast<double>(nearest.worstDist()));
    if (work == PeerWork::kSearch) {
      out[order[i]].radius = static_cast<float>(radius);
    } else {
      out[order[i]] =
          PlainAvgHexagram(sorted_positions.data(), sorted_normals.data(), i, nearest.indices(), k, radius, work);
    }
  });
  return {built - start, query};
}

}  // namespace curvd::bench
