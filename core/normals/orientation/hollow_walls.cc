#include "core/normals/orientation/hollow_walls.h"

#include <algorithm>
#include <cmath>

#include "core/normals/orientation/normal_links.h"

namespace curvd {
namespace {

// A wall is thinner than this share of the radius of a ball that has as much surface for its volume as the piece
// within.
constexpr double kThinWall = 0.5;
double VolumeOf(const PieceSums& piece) {
  double about_center = piece.flux;
  for (size_t axis = 0; axis < 3; ++axis) {
    about_center -= piece.center[axis] / piece.area * piece.normal_sum[axis];
  }
  return std::abs(about_center) / 3.0;
}

bool IsBoxWithin(const PieceSums& inner, const PieceSums& outer) {
  for (size_t axis = 0; axis < 3; ++axis) {
    if (!(inner.least[axis] > outer.least[axis] && inner.most[axis] < outer.most[axis])) return false;
  }
  return true;
}

bool MayLieWithin(const PieceSums& inner, const PieceSums& outer) {
  return VolumeOf(inner) < VolumeOf(outer) && IsBoxWithin(inner, outer);
}

// Areas and volumes are known up to a factor that they share.
bool IsThin(const PieceSums& inner, const PieceSums& outer) {
  const double least = VolumeOf(inner), most = VolumeOf(outer);
  const double thickness = 2.0 * (most - least) / (inner.area + outer.area);
  return thickness < kThinWall * 3.0 * least / inner.area;
}

}  // namespace

HollowWalls::HollowWalls(const SpatialIndex& index, const SideTree& tree, const PieceSides& sides,
                         const std::vector<uint8_t>& is_candidate)
    : index_(index), tree_(tree), sides_(sides) {
  const std::vector<PieceSums>& pieces = sides.pieces();
  std::vector<uint32_t> candidates;
  for (uint32_t piece = 0; piece < pieces.size(); ++piece) {
    if (is_candidate[piece] != 0) candidates.push_back(piece);
  }
  size_t thin_count = 0;
  for (const uint32_t inner : candidates) {
    for (const uint32_t outer : candidates) {
      if (outer == inner || !MayLieWithin(pieces[inner], pieces[outer])) continue;
      const bool is_thin = IsThin(pieces[inner], pieces[outer]);
      thin_count += is_thin ? 1 : 0;
      if (is_thin || pairs_.size() - thin_count < kMostPairs) pairs_.push_back({inner, outer, is_thin});
      if (thin_count > kMostPairs) {
        pairs_.clear();
        return;
      }
    }
  }
  if (pairs_.empty()) return;
  is_looked_at_.resize(pieces.size());
  for (const Pair& pair : pairs_) is_looked_at_[pair.inner] = is_looked_at_[pair.outer] = 1;
  chunks_.resize(tree.chunk_count());
  pieces_.resize(pieces.size());
}

size_t HollowWalls::Stride(uint32_t piece) const {
  return (static_cast<size_t>(sides_.pieces()[piece].points) + kSamples - 1) / kSamples;
}

void HollowWalls::SumChunk(size_t chunk) {
  const size_t first = chunk * SideTree::kChunkPoints;
  const size_t end = std::min(first + SideTree::kChunkPoints, index_.point_count());
  for (size_t place = first; place < end; ++place) {
    const uint32_t cluster = tree_.cluster(place);
    if (cluster == SideTree::kNoCluster) continue;
    const uint32_t piece = tree_.clusters()[cluster].piece;
    if (is_looked_at_[piece] == 0 || place % Stride(piece) != 0) continue;
    const size_t leaf = place / SpatialIndex::kLeafSize, lane = place % SpatialIndex::kLeafSize;
    const SpatialIndex::LeafPositions& p = index_.positions(leaf);
    const SpatialIndex::LeafNormals& n = index_.normals(leaf);
    const bool is_turned = tree_.is_opposite(place) != sides_.is_turned(cluster);
    const float area = tree_.area(place) * (is_turned ? -1.0f : 1.0f);
    chunks_[chunk].push_back(
        {piece, {p.x[lane], p.y[lane], p.z[lane]}, {area * n.x[lane], area * n.y[lane], area * n.z[lane]}});
  }
}

void HollowWalls::GroupSamples() {
  for (std::vector<Sample>& chunk : chunks_) {
    for (const Sample& sample : chunk) pieces_[sample.piece].push_back(sample);
    chunk = {};
  }
}

// 1 inside and 0 outside, as well as areas are known.
double HollowWalls::WindingAt(const std::array<float, 3>& position, uint32_t outer) const {
  double winding = 0.0;
  for (const Sample& sample : pieces_[outer]) {
    double squared = 0.0, along = 0.0;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double offset = static_cast<double>(sample.position[axis]) - position[axis];
      squared += offset * offset;
      along += offset * sample.moment[axis];
    }
    if (squared > 0.0) winding += along / (squared * std::sqrt(squared));
  }
  return winding * static_cast<double>(Stride(outer)) / (4.0 * kPointsPerArea);
}

void HollowWalls::CheckPair(size_t pair) {
  constexpr double kInside = 0.5;
  const std::vector<Sample>& own = pieces_[pairs_[pair].inner];
  const size_t step = std::max<size_t>(own.size() / kProbes, 1);
  double sum = 0.0, probes = 0.0;
  for (size_t i = 0; i < own.size(); i += step, ++probes) sum += WindingAt(own[i].position, pairs_[pair].outer);
  pairs_[pair].holds = sum > kInside * probes;
}

std::vector<uint32_t> HollowWalls::NearestAround(bool thin_alone) const {
  const std::vector<PieceSums>& pieces = sides_.pieces();
  std::vector<uint32_t> around(is_looked_at_.size(), kNone);
  for (const Pair& pair : pairs_) {
    if (!pair.holds || (thin_alone && !pair.is_thin)) continue;
    uint32_t& nearest = around[pair.inner];
    if (nearest == kNone || VolumeOf(pieces[pair.outer]) < VolumeOf(pieces[nearest])) nearest = pair.outer;
  }
  return around;
}

std::vector<uint32_t> HollowWalls::InnerPieces() const {
  const std::vector<uint32_t> around = NearestAround(true);
  std::vector<uint32_t> by_volume, inner;
  std::vector<double> volumes(is_looked_at_.size());
  for (uint32_t piece = 0; piece < is_looked_at_.size(); ++piece) {
    if (is_looked_at_[piece] == 0) continue;
    volumes[piece] = VolumeOf(sides_.pieces()[piece]);
    by_volume.push_back(piece);
  }
  // What is around a piece has a larger volume.
  std::stable_sort(by_volume.begin(), by_volume.end(), [&](uint32_t a, uint32_t b) { return volumes[a] > volumes[b]; });
  std::vector<uint8_t> is_inner(is_looked_at_.size());
  for (const uint32_t piece : by_volume) {
    is_inner[piece] = around[piece] != kNone && is_inner[around[piece]] == 0 ? 1 : 0;
    if (is_inner[piece] != 0) inner.push_back(piece);
  }
  std::sort(inner.begin(), inner.end());
  return inner;
}

size_t HollowWalls::AmbiguousCount() const {
  const std::vector<uint32_t> around = NearestAround(false), inner = InnerPieces();
  const auto is_inner = [&](uint32_t piece) { return std::binary_search(inner.begin(), inner.end(), piece); };
  size_t count = 0;
  for (uint32_t piece = 0; piece < around.size(); ++piece) {
    count += around[piece] != kNone && !is_inner(piece) && !is_inner(around[piece]) ? 1 : 0;
  }
  return count;
}

size_t HollowWalls::bytes() const {
  size_t bytes = pairs_.capacity() * sizeof(Pair) + is_looked_at_.capacity();
  for (const auto* groups : {&chunks_, &pieces_}) {
    for (const std::vector<Sample>& samples : *groups) bytes += samples.capacity() * sizeof(Sample);
  }
  return bytes;
}

size_t HollowWalls::MostBytes(size_t point_count) {
  // Of a vector that grows by doubling, and while samples are grouped both of the chunks and of the pieces.
  const size_t samples = std::min(point_count, (kSamples + 1) * (SideTree::kMostLargeClusters + 1));
  return 4 * samples * sizeof(Sample) + 4 * kMostPairs * sizeof(Pair);
}

}  // namespace curvd
