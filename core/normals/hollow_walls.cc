#include "core/normals/hollow_walls.h"

#include <algorithm>
#include <cmath>

#include "core/normals/normal_links.h"

namespace curvd {
namespace {

// A wall is thinner than this share of the radius of a ball that has as much surface for its volume as the piece
// within.
constexpr double kThinWall = 0.5;
// More pairs than that are not looked at: every one of them costs a million dipoles.
constexpr size_t kMostPairs = 256;

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

// Areas and volumes are known up to a factor that they share.
bool MayBeWall(const PieceSums& inner, const PieceSums& outer) {
  const double least = VolumeOf(inner), most = VolumeOf(outer);
  const double thickness = 2.0 * (most - least) / (inner.area + outer.area);
  return thickness > 0.0 && thickness < kThinWall * 3.0 * least / inner.area && IsBoxWithin(inner, outer);
}

}  // namespace

HollowWalls::HollowWalls(const SpatialIndex& index, const SideTree& tree, const PieceSides& sides,
                         const std::vector<uint8_t>& is_candidate)
    : index_(index), tree_(tree), sides_(sides), is_looked_at_(sides.pieces().size()), samples_(tree.chunk_count()) {
  const std::vector<PieceSums>& pieces = sides.pieces();
  for (uint32_t inner = 0; inner < pieces.size(); ++inner) {
    for (uint32_t outer = 0; is_candidate[inner] != 0 && outer < pieces.size(); ++outer) {
      if (outer == inner || is_candidate[outer] == 0 || !MayBeWall(pieces[inner], pieces[outer])) continue;
      if (pairs_.size() == kMostPairs) return;
      pairs_.push_back({inner, outer});
      is_looked_at_[inner] = is_looked_at_[outer] = 1;
    }
  }
}

size_t HollowWalls::Stride(uint32_t piece) const {
  return std::max<size_t>(static_cast<size_t>(sides_.pieces()[piece].points) / kSamples, 1);
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
    samples_[chunk].push_back(
        {piece, {p.x[lane], p.y[lane], p.z[lane]}, {area * n.x[lane], area * n.y[lane], area * n.z[lane]}});
  }
}

// 1 inside and 0 outside, as well as areas are known.
double HollowWalls::WindingAt(const std::array<float, 3>& position, uint32_t outer) const {
  double winding = 0.0;
  for (const std::vector<Sample>& chunk : samples_) {
    for (const Sample& sample : chunk) {
      if (sample.piece != outer) continue;
      double squared = 0.0, along = 0.0;
      for (size_t axis = 0; axis < 3; ++axis) {
        const double offset = static_cast<double>(sample.position[axis]) - position[axis];
        squared += offset * offset;
        along += offset * sample.moment[axis];
      }
      if (squared > 0.0) winding += along / (squared * std::sqrt(squared));
    }
  }
  return winding * static_cast<double>(Stride(outer)) / (4.0 * kPointsPerArea);
}

void HollowWalls::CheckPair(size_t pair) {
  const uint32_t inner = pairs_[pair].inner, outer = pairs_[pair].outer;
  std::vector<const Sample*> own;
  for (const std::vector<Sample>& chunk : samples_) {
    for (const Sample& sample : chunk) {
      if (sample.piece == inner) own.push_back(&sample);
    }
  }
  const size_t step = std::max<size_t>(own.size() / kProbes, 1);
  double sum = 0.0;
  size_t probes = 0;
  for (size_t i = 0; i < own.size(); i += step, ++probes) sum += WindingAt(own[i]->position, outer);
  constexpr double kInside = 0.5;
  pairs_[pair].holds = probes > 0 && sum > kInside * static_cast<double>(probes);
}

std::vector<uint32_t> HollowWalls::InnerPieces() const {
  std::vector<uint32_t> depths(sides_.pieces().size()), inner;
  for (const Pair& pair : pairs_) depths[pair.inner] += pair.holds ? 1 : 0;
  for (uint32_t piece = 0; piece < depths.size(); ++piece) {
    if (depths[piece] % 2 == 1) inner.push_back(piece);
  }
  return inner;
}

}  // namespace curvd
