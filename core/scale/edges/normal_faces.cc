#include "core/scale/edges/normal_faces.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>

#include "Eigen/Core"

namespace curvd {
namespace {

using Eigen::Vector3d;

// Single normals that are off make no face.
constexpr size_t kLeastInCluster = 3;

// What two and three faces leave of the spread of normals, which is a quarter and a ninth on a bend.
constexpr double kMostInTwo = 0.12, kMostInThree = 0.05;

// The mean squared distance of normals from the nearest of the means of so many clusters, by Lloyd's method from
// normals that are far from each other. Nothing if a cluster has fewer than kLeastInCluster.
template <size_t kClusters>
std::optional<double> SpreadInClusters(std::span<const NeighborNormal> neighbors) {
  constexpr int kRounds = 4;
  std::array<Vector3d, kClusters> means;
  const auto nearest = [&](const Vector3d& normal, size_t among) {
    std::pair<double, size_t> best = {std::numeric_limits<double>::infinity(), 0};
    for (size_t c = 0; c < among; ++c) best = std::min(best, {(normal - means[c]).squaredNorm(), c});
    return best;
  };
  means[0] = neighbors.front().normal;
  for (size_t c = 1; c < kClusters; ++c) {
    means[c] = std::max_element(neighbors.begin(), neighbors.end(), [&](const auto& a, const auto& b) {
                 return nearest(a.normal, c).first < nearest(b.normal, c).first;
               })->normal;
  }
  double spread = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    std::array<Vector3d, kClusters> sums;
    std::array<size_t, kClusters> counts{};
    sums.fill(Vector3d::Zero());
    for (const NeighborNormal& neighbor : neighbors) {
      const size_t c = nearest(neighbor.normal, kClusters).second;
      sums[c] += neighbor.normal;
      ++counts[c];
    }
    if (*std::min_element(counts.begin(), counts.end()) < kLeastInCluster) return std::nullopt;
    for (size_t c = 0; c < kClusters; ++c) means[c] = sums[c] / static_cast<double>(counts[c]);
  }
  for (const NeighborNormal& neighbor : neighbors) spread += nearest(neighbor.normal, kClusters).first;
  return spread / static_cast<double>(neighbors.size());
}

}  // namespace

NormalSpread SpreadOf(std::span<const NeighborNormal> neighbors) {
  Vector3d mean = Vector3d::Zero();
  for (const NeighborNormal& neighbor : neighbors) mean += neighbor.normal;
  mean /= static_cast<double>(neighbors.size());
  double squares = 0.0;
  for (const NeighborNormal& neighbor : neighbors) squares += (neighbor.normal - mean).squaredNorm();
  const double all = squares / static_cast<double>(neighbors.size());
  return {all, SpreadInClusters<2>(neighbors).value_or(all), SpreadInClusters<3>(neighbors).value_or(all)};
}

bool AreOfFaces(const NormalSpread& spread, double noise) {
  const double of_noise = 2.0 * noise * noise;
  return spread.in_two - of_noise < kMostInTwo * spread.all || spread.in_three - of_noise < kMostInThree * spread.all;
}

}  // namespace curvd
