#include "core/estimators/delaunay/umbrella_triangles.h"

#include <algorithm>
#include <bit>

namespace curvd {

bool UmbrellaTriangles::Gather(const SpatialIndex& index, const Umbrella* umbrellas, const LeafList& leaves) {
  if (source_ == &leaves && generation_ == leaves.generation()) return false;
  source_ = &leaves;
  generation_ = leaves.generation();
  leaf_count_ = leaves.size();
  SetPositions(leaves);
  constexpr size_t kLeaf = SpatialIndex::kLeafSize;
  const size_t places = leaf_count_ * kLeaf;
  weights_.Reserve(places);
  std::fill_n(weights_.data(), places, kNoNeighbor);
  corners_.Reserve(places);
  first_.Reserve(leaf_count_ + 1);
  size_ = lookups_ = 0;
  for (size_t i = 0; i < leaf_count_; ++i) {
    first_[i] = static_cast<uint32_t>(size_);
    triangles_.Reserve(size_ + kLeaf * Umbrella::kMaxTriangles);
    const size_t leaf = leaves.leaf(i);
    const int count = index.LeafPoints(leaf);
    for (int lane = 0; lane < count; ++lane) {
      Add(umbrellas[leaf * kLeaf + lane], static_cast<uint32_t>(i * kLeaf + lane));
    }
  }
  first_[leaf_count_] = static_cast<uint32_t>(size_);
  triangles_.Reserve(size_ + kPad);
  std::fill_n(triangles_.data() + size_, kPad, Triangle{});
  measures_.Reserve(size_);
  return true;
}

size_t UmbrellaTriangles::bytes() const {
  return positions_.bytes() + first_.bytes() + triangles_.bytes() + measures_.bytes() + corners_.bytes() +
         weights_.bytes();
}

size_t UmbrellaTriangles::MostBytes(size_t leaves) {
  const size_t places = leaves * SpatialIndex::kLeafSize, triangles = places * Umbrella::kMaxTriangles;
  return ScratchArray<Position>::MostBytes(std::bit_ceil(2 * leaves + 1)) +
         ScratchArray<uint32_t>::MostBytes(leaves + 1) + ScratchArray<Triangle>::MostBytes(triangles + kPad) +
         ScratchArray<TriangleMeasures>::MostBytes(triangles) + ScratchArray<TriangleCorner>::MostBytes(places) +
         ScratchArray<float>::MostBytes(places);
}

void UmbrellaTriangles::SetPositions(const LeafList& leaves) {
  const size_t capacity = std::bit_ceil(2 * leaves.size() + 1);
  position_mask_ = static_cast<uint32_t>(capacity - 1);
  has_homeless_ = false;
  positions_.Reserve(capacity);
  std::fill_n(positions_.data(), capacity, Position{0, kNowhere});
  for (size_t i = 0; i < leaves.size(); ++i) {
    uint32_t at = leaves.leaf(i) & position_mask_, probes = 0;
    while (probes < kMostProbes && positions_[at].position != kNowhere) {
      at = (at + 1) & position_mask_;
      ++probes;
    }
    if (probes < kMostProbes) {
      positions_[at] = {leaves.leaf(i), static_cast<uint32_t>(i)};
    } else {
      has_homeless_ = true;
    }
  }
}

uint32_t UmbrellaTriangles::PositionOf(uint32_t leaf) const {
  uint32_t at = leaf & position_mask_;
  for (uint32_t probes = 0; probes < kMostProbes; ++probes, at = (at + 1) & position_mask_) {
    const Position& position = positions_[at];
    if (position.position == kNowhere || position.leaf == leaf) return position.position;
  }
  return has_homeless_ ? BisectPosition(leaf) : kNowhere;
}

uint32_t UmbrellaTriangles::BisectPosition(uint32_t leaf) const {
  const uint32_t* const end = source_->leaves() + leaf_count_;
  const uint32_t* const found = std::lower_bound(source_->leaves(), end, leaf);
  return found != end && *found == leaf ? static_cast<uint32_t>(found - source_->leaves()) : kNowhere;
}

uint32_t UmbrellaTriangles::PlaceOf(int32_t tree_place) const {
  constexpr uint32_t kLeaf = SpatialIndex::kLeafSize;
  const uint32_t position = PositionOf(static_cast<uint32_t>(tree_place) / kLeaf);
  return position == kNowhere ? kNowhere : position * kLeaf + static_cast<uint32_t>(tree_place) % kLeaf;
}

void UmbrellaTriangles::Add(const Umbrella& umbrella, uint32_t place) {
  for (uint32_t rest = umbrella.occurrences; rest != 0;) {
    const int triangle = std::countr_zero(rest) / 2;
    rest &= ~(uint32_t{3} << (2 * triangle));
    lookups_ += 2;
    const uint32_t a = PlaceOf(umbrella.rim[triangle]), b = PlaceOf(umbrella.rim[triangle + 1]);
    if (a == kNowhere || b == kNowhere) continue;
    triangles_[size_++] = {{place, a, b}, static_cast<uint32_t>(umbrella.Occurrences(triangle))};
  }
}

}  // namespace curvd
