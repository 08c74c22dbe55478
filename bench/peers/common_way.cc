#include <cmath>
#include <cstdint>
#include <vector>

#include "bench/peers/packed_points.h"
#include "bench/peers/peers.h"
#include "bench/peers/plain_estimator.h"
#include "bench/peers/sampled_queries.h"
#include "bench/stopwatch.h"

namespace curvd::bench {

PeerCost RunCommonWay(std::span<const double> positions, std::span<const double> normals, size_t k, PeerWork work,
                      PointCurvature* out, size_t one_in) {
  const double start = CpuSeconds();
  const PackedPoints<double> points{positions.data(), positions.size() / 3};
  NanoflannTree<double> tree(3, points, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  tree.buildIndex();
  const double built = CpuSeconds();
  std::vector<uint32_t> neighbors(k);
  std::vector<double> squared_distances(k);
  const double query = AnswerQueries(points.count, one_in, [&](uint32_t i) {
    tree.knnSearch(&positions[3 * size_t{i}], k, neighbors.data(), squared_distances.data());
    const double radius = std::sqrt(squared_distances[k - 1]);
    if (work == PeerWork::kSearch) {
      out[i].radius = static_cast<float>(radius);
    } else {
      out[i] = PlainAvgHexagram(positions.data(), normals.data(), i, neighbors.data(), k, radius, work);
    }
  });
  return {built - start, query};
}

}  // namespace curvd::bench
