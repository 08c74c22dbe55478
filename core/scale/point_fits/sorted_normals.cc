#include "core/scale/point_fits/sorted_normals.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/scale/pilot/neighbor_copies.h"

namespace curvd {

void SortNormals(float most, PilotScratch& s) {
  const NeighborArrays& n = s.neighbors;
  std::vector<uint32_t>& order = s.order;
  std::vector<float>& squared = s.squared;
  std::vector<NeighborNormal>& neighbors = s.normals;
  order.clear();
  squared.resize(n.count);
  for (uint32_t j = 0; j < n.count; ++j) {
    squared[j] = n.dx[j] * n.dx[j] + n.dy[j] * n.dy[j] + n.dz[j] * n.dz[j];
    if (squared[j] <= most * most) order.push_back(j);
  }
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return squared[a] != squared[b] ? squared[a] < squared[b] : s.ids[a] < s.ids[b];
  });
  neighbors.clear();
  MarkCopies(s);
  for (const uint32_t j : order) {
    if (IsCopy(s.ids[j])) continue;
    neighbors.push_back({Eigen::Vector3d(n.dx[j], n.dy[j], n.dz[j]), Eigen::Vector3d(n.nx[j], n.ny[j], n.nz[j])});
  }
}

}  // namespace curvd
