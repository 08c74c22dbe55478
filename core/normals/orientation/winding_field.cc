#include "core/normals/orientation/winding_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace curvd {
namespace {

// A node is a dipole to points that are farther from its middle than this many times half its diagonal, squared.
constexpr double kFarSquared = 6.0;
// Nodes that are looked into for one sample; ordinary clouds of 10 million points need a few thousand.
constexpr size_t kMostVisited = 50'000;
constexpr size_t kBlockSamples = 64;

template <typename Vector, typename OtherVector>
double DipoleField(const Vector& offset, const OtherVector& moment, double softening) {
  const double squared = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
  const double soft = squared + softening;
  if (!(squared > 0.0)) return 0.0;
  const double product = offset[0] * static_cast<double>(moment[0]) + offset[1] * static_cast<double>(moment[1]) +
                         offset[2] * static_cast<double>(moment[2]);
  return product / (soft * std::sqrt(soft)) / (4.0 * kPointsPerArea);
}

// Of a box, seen from a query.
bool IsFar(const Box& box, const float* query) {
  double squared = 0.0, reach = 0.0;
  for (size_t axis = 0; axis < 3; ++axis) {
    const double lo = box.lo[axis], hi = box.hi[axis];
    const double offset = 0.5 * (lo + hi) - query[axis], half = 0.5 * (hi - lo);
    squared += offset * offset;
    reach += half * half;
  }
  return squared > kFarSquared * reach;
}

}  // namespace

WindingField::WindingField(const SpatialIndex& index, const SideTree& tree, const std::vector<uint32_t>& wanted)
    : index_(index), tree_(tree), chunks_(tree.chunk_count()), of_groups_(index.group_count()) {
  above_groups_.resize(index.group_count());
  column_.resize(tree.clusters().size(), kNoColumn);
  field_of_.resize(tree.piece_count(), kNoColumn);
  for (const uint32_t piece : wanted) {
    field_of_[piece] = static_cast<uint32_t>(pieces_.size());
    pieces_.push_back({.piece = piece});
  }
  for (size_t i = 0; i < column_.size(); ++i) {
    const uint32_t field = field_of_[tree.clusters()[i].piece];
    if (field == kNoColumn) continue;
    column_[i] = static_cast<uint32_t>(pieces_[field].clusters.size());
    pieces_[field].clusters.push_back(static_cast<uint32_t>(i));
  }
}

// `a` and `b` are of one cluster.
WindingField::Dipole WindingField::Sum(const Dipole& a, const Dipole& b) {
  Dipole sum = a;
  sum.points += b.points;
  sum.area += b.area;
  for (size_t axis = 0; axis < 3; ++axis) {
    sum.moment[axis] += b.moment[axis];
    if (sum.area > 0.0f) sum.center[axis] = (a.area * a.center[axis] + b.area * b.center[axis]) / sum.area;
  }
  return sum;
}

void WindingField::SumGroup(size_t group, std::vector<Dipole>& out) const {
  const size_t start = out.size();
  const size_t first = group * SpatialIndex::kGroupPoints;
  const size_t last = std::min(first + SpatialIndex::kGroupPoints, index_.point_count());
  for (size_t place = first; place < last; ++place) {
    const uint32_t cluster = tree_.cluster(place);
    if (cluster == SideTree::kNoCluster || !IsLookedAt(cluster)) continue;
    const size_t leaf = place / SpatialIndex::kLeafSize, lane = place % SpatialIndex::kLeafSize;
    const SpatialIndex::LeafPositions& p = index_.positions(leaf);
    const SpatialIndex::LeafNormals& n = index_.normals(leaf);
    const float area = tree_.area(place), side = tree_.is_opposite(place) ? -area : area;
    const Dipole own{
        cluster, 1, area, {p.x[lane], p.y[lane], p.z[lane]}, {side * n.x[lane], side * n.y[lane], side * n.z[lane]}};
    const auto found = std::find_if(out.begin() + static_cast<std::ptrdiff_t>(start), out.end(),
                                    [&](const Dipole& dipole) { return dipole.cluster == cluster; });
    found == out.end() ? out.push_back(own) : void(*found = Sum(*found, own));
  }
  std::sort(out.begin() + static_cast<std::ptrdiff_t>(start), out.end(),
            [](const Dipole& a, const Dipole& b) { return a.cluster < b.cluster; });
}

void WindingField::SumChunk(size_t chunk) {
  std::vector<Dipole>& dipoles = chunks_[chunk];
  const size_t first = chunk * SideTree::kChunkGroups;
  const size_t last = std::min(first + SideTree::kChunkGroups, index_.group_count());
  for (size_t group = first; group < last; ++group) {
    const size_t before = dipoles.size();
    SumGroup(group, dipoles);
    of_groups_[group] = {before, dipoles.size()};
  }
}

const WindingField::Range& WindingField::RangeOf(const Place& place) const {
  return place.is_group() ? of_groups_[GroupOf(place)] : above_groups_[NameOf(place)];
}

WindingField::Range WindingField::SumBelow(const Place& place) {
  if (place.is_group()) return of_groups_[GroupOf(place)];
  const Range left = SumBelow(place.Left()), right = SumBelow(place.Right());
  const size_t before = dipoles_.size();
  size_t a = left.first, b = right.first;
  while (a < left.last || b < right.last) {
    const bool takes_a = b == right.last || (a < left.last && dipoles_[a].cluster <= dipoles_[b].cluster);
    const bool takes_b = a == left.last || (b < right.last && dipoles_[b].cluster <= dipoles_[a].cluster);
    const Dipole sum = takes_a && takes_b ? Sum(dipoles_[a], dipoles_[b]) : dipoles_[takes_a ? a : b];
    dipoles_.push_back(sum);
    a += takes_a ? 1 : 0;
    b += takes_b ? 1 : 0;
  }
  return above_groups_[NameOf(place)] = {before, dipoles_.size()};
}

void WindingField::Finish() {
  size_t count = 0;
  for (const std::vector<Dipole>& chunk : chunks_) count += chunk.size();
  dipoles_.reserve(2 * count);
  for (size_t chunk = 0; chunk < chunks_.size(); ++chunk) {
    const size_t first = chunk * SideTree::kChunkGroups;
    const size_t last = std::min(first + SideTree::kChunkGroups, index_.group_count());
    for (size_t group = first; group < last; ++group) {
      of_groups_[group].first += dipoles_.size();
      of_groups_[group].last += dipoles_.size();
    }
    dipoles_.insert(dipoles_.end(), chunks_[chunk].begin(), chunks_[chunk].end());
    chunks_[chunk] = {};
  }
  if (index_.group_count() == 0) return;
  const Range all = SumBelow({0, 0, index_.leaf_count()});
  for (FieldPiece& piece : pieces_) piece.moments.resize(piece.clusters.size());
  for (size_t d = all.first; d < all.last; ++d) {
    const Dipole& dipole = dipoles_[d];
    FieldPiece& piece = pieces_[field_of_[tree_.clusters()[dipole.cluster].piece]];
    piece.moments[column_[dipole.cluster]] = dipole.moment;
    piece.area += dipole.area;
  }
  ChooseSamples();
}

// Spreads the samples of each cluster evenly over its points in tree order.
void WindingField::ChooseSamples() {
  const std::vector<Cluster>& clusters = tree_.clusters();
  struct Progress {
    uint64_t seen = 0, taken = 0;
  };
  std::vector<Progress> progress(clusters.size());
  for (size_t group = 0; group < index_.group_count(); ++group) {
    for (size_t d = of_groups_[group].first; d < of_groups_[group].last; ++d) {
      const uint32_t cluster = dipoles_[d].cluster;
      const uint64_t points = clusters[cluster].points;
      const uint64_t spread = (kSpreadSamples * points + index_.point_count() - 1) / index_.point_count();
      const uint64_t most = std::min(points, std::max<uint64_t>(kLeastOfCluster, spread));
      FieldPiece& piece = pieces_[field_of_[clusters[cluster].piece]];
      Progress& at = progress[cluster];
      uint64_t ordinal = at.seen;
      at.seen += dipoles_[d].points;
      const auto next = [&] { return (2 * at.taken + 1) * points / (2 * most); };
      const size_t first = group * SpatialIndex::kGroupPoints;
      for (size_t place = first; ordinal < at.seen && at.taken < most && next() < at.seen; ++place) {
        if (tree_.cluster(place) != cluster || ordinal++ != next()) continue;
        ++at.taken;
        // Coincident points have no area, and no winding number.
        const bool counts = tree_.area(place) > 0.0f;
        piece.samples.push_back(
            {static_cast<uint32_t>(place), counts ? static_cast<float>(points) / static_cast<float>(most) : 0.0f});
      }
    }
  }
  for (size_t i = 0; i < pieces_.size(); ++i) {
    FieldPiece& piece = pieces_[i];
    piece.values.resize(piece.samples.size() * piece.clusters.size());
    for (size_t first = 0; first < piece.samples.size(); first += kBlockSamples) {
      blocks_.push_back({i, first, std::min(first + kBlockSamples, piece.samples.size())});
    }
  }
}

// Calls add(cluster, position, moment) for each point of the piece in a group.
template <typename Add>
void WindingField::VisitGroup(const Place& place, uint32_t piece, const Add& add) const {
  const size_t first = place.first_leaf * SpatialIndex::kLeafSize;
  const size_t last = std::min(first + place.leaves * SpatialIndex::kLeafSize, index_.point_count());
  for (size_t point = first; point < last; ++point) {
    const uint32_t cluster = tree_.cluster(point);
    if (cluster == SideTree::kNoCluster || tree_.clusters()[cluster].piece != piece) continue;
    const float area = tree_.area(point), side = tree_.is_opposite(point) ? -area : area;
    if (area == 0.0f) continue;
    const size_t leaf = point / SpatialIndex::kLeafSize, lane = point % SpatialIndex::kLeafSize;
    const SpatialIndex::LeafPositions& p = index_.positions(leaf);
    const SpatialIndex::LeafNormals& n = index_.normals(leaf);
    add(cluster, std::array<float, 3>{p.x[lane], p.y[lane], p.z[lane]},
        std::array<float, 3>{side * n.x[lane], side * n.y[lane], side * n.z[lane]});
  }
}

void WindingField::FillSample(size_t sample, FieldPiece& piece) const {
  const size_t own = piece.samples[sample].place;
  const SpatialIndex::LeafPositions& p = index_.positions(own / SpatialIndex::kLeafSize);
  const size_t lane = own % SpatialIndex::kLeafSize;
  const float query[3] = {p.x[lane], p.y[lane], p.z[lane]};
  // As far as the points are apart, the surface between them is not known: neighbors count less.
  const double softening = tree_.area(own) * std::numbers::pi / kPointsPerArea;
  const auto add = [&](uint32_t cluster, const std::array<float, 3>& at, const std::array<float, 3>& moment) {
    const double offset[3] = {static_cast<double>(at[0]) - query[0], static_cast<double>(at[1]) - query[1],
                              static_cast<double>(at[2]) - query[2]};
    piece.values[column_[cluster] * piece.samples.size() + sample] +=
        static_cast<float>(DipoleField(offset, moment, softening));
  };
  constexpr size_t kMostOpen = 64;  // the tree is balanced over fewer than 2^31 leaves
  Place open[kMostOpen];
  size_t count = 0;
  open[count++] = {0, 0, index_.leaf_count()};
  for (size_t visited = 0; count > 0; ++visited) {
    const Place at = open[--count];
    const Range& range = RangeOf(at);
    if (range.first == range.last) continue;
    if (visited > kMostVisited || IsFar(index_.node(at.node).box, query)) {
      for (size_t d = range.first; d < range.last; ++d) {
        const Dipole& dipole = dipoles_[d];
        if (tree_.clusters()[dipole.cluster].piece != piece.piece) continue;
        add(dipole.cluster, dipole.center, dipole.moment);
      }
    } else if (at.is_group()) {
      VisitGroup(at, piece.piece, add);
    } else {
      open[count++] = at.Right();
      open[count++] = at.Left();
    }
  }
}

void WindingField::Sample(size_t block, const std::atomic<bool>& stopped) {
  const SampleBlock& own = blocks_[block];
  FieldPiece& piece = pieces_[own.piece];
  for (size_t i = own.first; i < own.last && !stopped.load(std::memory_order_relaxed); ++i) {
    if (piece.samples[i].weight > 0.0f) FillSample(i, piece);
  }
}

size_t WindingField::bytes() const {
  size_t bytes = dipoles_.capacity() * sizeof(Dipole) + 2 * of_groups_.capacity() * sizeof(Range) +
                 column_.capacity() * sizeof(uint32_t) + field_of_.capacity() * sizeof(uint32_t);
  for (const auto& chunk : chunks_) bytes += chunk.capacity() * sizeof(Dipole);
  for (const FieldPiece& piece : pieces_) {
    bytes += piece.values.capacity() * sizeof(float) + piece.samples.capacity() * sizeof(FieldSample) +
             piece.clusters.capacity() * sizeof(uint32_t) + piece.moments.capacity() * sizeof(piece.moments[0]);
  }
  return bytes;
}

size_t WindingField::MostBytes(size_t point_count) {
  const size_t clusters = std::min(point_count / SideTree::kLeastCluster + 1, SideTree::kMostLargeClusters + 1);
  const size_t samples = std::min(point_count, kSpreadSamples + (kLeastOfCluster + 1) * clusters);
  // A vector that grows by doubling holds twice its size.
  return samples * (clusters * sizeof(float) + 2 * sizeof(FieldSample)) +
         clusters * (2 * sizeof(FieldPiece) + sizeof(std::array<float, 3>));
}

}  // namespace curvd
