#include "core/normals/orientation/piece_sides.h"

#include <algorithm>
#include <cmath>

namespace curvd {
namespace {

PieceSums SumsOfPoint(const SpatialIndex& index, const SideTree& tree, size_t place) {
  const size_t leaf = place / SpatialIndex::kLeafSize, lane = place % SpatialIndex::kLeafSize;
  const SpatialIndex::LeafPositions& p = index.positions(leaf);
  const SpatialIndex::LeafNormals& n = index.normals(leaf);
  const bool opposite = tree.is_opposite(place);
  const double area = tree.area(place), side = opposite ? -area : area;
  PieceSums sums;
  sums.points = 1;
  sums.kept_points = opposite ? 0 : 1;
  sums.area = area;
  sums.kept_area = opposite ? 0.0 : area;
  sums.least = sums.most = {p.x[lane], p.y[lane], p.z[lane]};
  sums.center = {area * p.x[lane], area * p.y[lane], area * p.z[lane]};
  sums.normal_sum = {side * n.x[lane], side * n.y[lane], side * n.z[lane]};
  sums.flux = sums.normal_sum[0] * p.x[lane] + sums.normal_sum[1] * p.y[lane] + sums.normal_sum[2] * p.z[lane];
  return sums;
}

double Norm(const std::array<double, 3>& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

}  // namespace

PieceSums PieceSums::Turned() const {
  PieceSums turned = *this;
  turned.kept_points = points - kept_points;
  turned.kept_area = area - kept_area;
  for (double& component : turned.normal_sum) component = -component;
  turned.flux = -flux;
  return turned;
}

void PieceSums::Add(const PieceSums& other) {
  points += other.points;
  kept_points += other.kept_points;
  area += other.area;
  kept_area += other.kept_area;
  for (size_t axis = 0; axis < 3; ++axis) {
    center[axis] += other.center[axis];
    normal_sum[axis] += other.normal_sum[axis];
    least[axis] = std::min(least[axis], other.least[axis]);
    most[axis] = std::max(most[axis], other.most[axis]);
  }
  flux += other.flux;
}

bool IsClosed(const PieceSums& piece) {
  return piece.area > 0.0 && Norm(piece.normal_sum) <= kMostClosedShare * piece.area;
}

bool IsToBeTurned(const PieceSums& piece, const SideRule& rule) {
  if (IsClosed(piece) || (rule.all_closed && piece.area > 0.0)) {
    // By the divergence theorem, the flux of the position is three times the volume inside. Taken about the center, so
    // that holes matter less.
    double about_center = piece.flux;
    for (size_t axis = 0; axis < 3; ++axis) {
      about_center -= piece.center[axis] / piece.area * piece.normal_sum[axis];
    }
    return about_center < 0.0;
  }
  if (rule.keeps_majority) {
    return piece.area > 0.0 ? piece.kept_area < 0.5 * piece.area : 2 * piece.kept_points < piece.points;
  }
  const auto less = [](double a, double b) { return std::abs(a) < std::abs(b); };
  return *std::max_element(piece.normal_sum.begin(), piece.normal_sum.end(), less) < 0.0;
}

void PieceSides::SumChunk(size_t chunk) {
  std::vector<PieceSums>& sums = chunks_[chunk];
  sums.clear();
  size_t last = 0;  // which of them is the last point's: the next one's most times
  const size_t first = chunk * SideTree::kChunkPoints;
  const size_t end = std::min(first + SideTree::kChunkPoints, index_.point_count());
  for (size_t place = first; place < end; ++place) {
    const uint32_t cluster = tree_.cluster(place);
    if (cluster == SideTree::kNoCluster) continue;
    if (last >= sums.size() || sums[last].number != cluster) {
      const auto found =
          std::find_if(sums.begin(), sums.end(), [&](const PieceSums& s) { return s.number == cluster; });
      last = static_cast<size_t>(found - sums.begin());
      if (found == sums.end()) sums.push_back({.number = cluster});
    }
    sums[last].Add(SumsOfPoint(index_, tree_, place));
  }
  sums.shrink_to_fit();
}

void PieceSides::Finish(const SideRule& rule) {
  const std::vector<Cluster>& clusters = tree_.clusters();
  pieces_.resize(tree_.piece_count());
  for (size_t i = 0; i < pieces_.size(); ++i) pieces_[i].number = static_cast<uint32_t>(i);
  for (std::vector<PieceSums>& chunk : chunks_) {
    for (const PieceSums& sums : chunk) {
      const Cluster& cluster = clusters[sums.number];
      pieces_[cluster.piece].Add(cluster.is_opposite ? sums.Turned() : sums);
    }
    chunk = {};
  }
  std::vector<uint8_t> is_piece_turned;
  for (const PieceSums& piece : pieces_) is_piece_turned.push_back(IsToBeTurned(piece, rule) ? 1 : 0);
  for (const Cluster& cluster : clusters) {
    turned_.push_back(is_piece_turned[cluster.piece] ^ (cluster.is_opposite ? 1 : 0));
  }
}

size_t PieceSides::bytes() const {
  size_t bytes = pieces_.capacity() * sizeof(PieceSums) + turned_.capacity();
  for (const auto& chunk : chunks_) bytes += chunk.capacity() * sizeof(PieceSums);
  return bytes;
}

}  // namespace curvd
