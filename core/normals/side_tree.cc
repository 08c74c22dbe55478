#include "core/normals/side_tree.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>

namespace curvd {
namespace {

// Pieces follow only pieces of a lower rank, so that none follow each other in a circle, and that the ways which they
// go are short: ranks are random (the finalizer of MurmurHash3, a bijection).
uint32_t RankOf(uint32_t root) {
  root = (root ^ root >> 16) * 0x85EBCA6Bu;
  root = (root ^ root >> 13) * 0xC2B2AE35u;
  return root ^ root >> 16;
}

template <typename T>
absl::Status CreateArray(size_t size, PageArray<T>& array) {
  auto created = PageArray<T>::Create(size);
  if (created.ok()) array = *std::move(created);
  return created.status();
}

}  // namespace

size_t SideTree::ChunkEnd(size_t chunk) const { return std::min((chunk + 1) * kChunkPoints, index_.point_count()); }

absl::Status SideTree::Start() {
  const size_t points = index_.point_count();
  links_.resize(chunk_count());
  absl::Status status = CreateArray(points, parents_);
  if (status.ok()) status = CreateArray(points, offers_);
  if (status.ok()) status = CreateArray(points, pieces_);
  if (status.ok()) status = CreateArray(points, areas_);
  return status;
}

absl::Status SideTree::Link(size_t chunk, LinkScratch& scratch, ForestScratch& forest) {
  const size_t first = chunk * kChunkPoints, last = ChunkEnd(chunk);
  scratch.link_count = 0;
  const size_t first_group = chunk * kChunkGroups,
               end_group = std::min(first_group + kChunkGroups, index_.group_count());
  for (size_t group = first_group; group < end_group; ++group) {
    const absl::Status status = AppendLinks(index_, plan_, group, scratch, areas_.data());
    if (!status.ok()) return status;
  }
  NormalLink* const links = scratch.links.data();
  const size_t kept =
      KeepForest(links, scratch.link_count, static_cast<uint32_t>(first), static_cast<uint32_t>(last), forest);
  // More than two links a point have nearly all their ends in other chunks; the dearest of those are given up.
  links_[chunk].assign(links, links + std::min(kept, kMostKept));
  for (size_t place = first; place < last; ++place) {
    const SpatialIndex::LeafNormals& normals = index_.normals(place / SpatialIndex::kLeafSize);
    const float x = normals.x[place % SpatialIndex::kLeafSize];
    parents_[place] = x == x ? Join(static_cast<uint32_t>(place), 0) : kNone;
    offers_[place] = kNoLink;
  }
  return absl::OkStatus();
}

bool SideTree::HasLinks() const {
  return std::any_of(links_.begin(), links_.end(), [](const auto& links) { return !links.empty(); });
}

void SideTree::Offer(uint32_t root, uint64_t offer) {
  const std::atomic_ref<uint64_t> best(offers_[root]);
  uint64_t seen = best.load(std::memory_order_relaxed);
  while (offer < seen && !best.compare_exchange_weak(seen, offer, std::memory_order_relaxed)) {
  }
}

void SideTree::Propose(size_t chunk) {
  std::vector<NormalLink>& links = links_[chunk];
  size_t kept = 0;
  for (const NormalLink& link : links) {
    const uint32_t root_a = parents_[link.a] >> 1, root_b = parents_[link.b] >> 1;
    if (root_a == root_b) continue;
    const uint64_t name = chunk << kLinkBits | kept;
    const uint64_t offer = uint64_t{std::bit_cast<uint32_t>(link.cost)} << 32 | name;
    links[kept++] = link;
    Offer(root_a, offer);
    Offer(root_b, offer);
  }
  links.resize(kept);
}

void SideTree::Follow(size_t chunk) {
  for (size_t place = chunk * kChunkPoints; place < ChunkEnd(chunk); ++place) {
    if (!IsRoot(place)) continue;
    const auto root = static_cast<uint32_t>(place);
    pieces_[root] = Join(root, 0);
    if (offers_[root] == kNoLink) continue;
    const auto name = static_cast<uint32_t>(offers_[root]);
    const NormalLink& link = links_[name >> kLinkBits][name & (kMostKept - 1)];
    const uint32_t a = parents_[link.a], b = parents_[link.b];
    const uint32_t other = a >> 1 == root ? b >> 1 : a >> 1;
    if (RankOf(other) < RankOf(root)) pieces_[root] = Join(other, (a ^ b ^ link.opposite) & 1);
  }
}

void SideTree::Flatten(size_t chunk) {
  for (size_t place = chunk * kChunkPoints; place < ChunkEnd(chunk); ++place) {
    offers_[place] = kNoLink;
    if (parents_[place] == kNone) continue;
    uint32_t root = parents_[place] >> 1, opposite = parents_[place] & 1;
    for (uint32_t next = pieces_[root]; next >> 1 != root; next = pieces_[root]) {
      root = next >> 1;
      opposite ^= next & 1;
    }
    parents_[place] = Join(root, opposite);
  }
}

size_t SideTree::NumberPieces() {
  offers_ = {};
  links_ = {};
  size_t count = 0;
  for (size_t place = 0; place < index_.point_count(); ++place) {
    if (IsRoot(place)) pieces_[place] = static_cast<uint32_t>(count++);
  }
  return count;
}

void SideTree::Clear() {
  links_ = {};
  parents_ = {};
  offers_ = {};
  pieces_ = {};
  areas_ = {};
}

size_t SideTree::bytes() const {
  size_t bytes = parents_.bytes() + offers_.bytes() + pieces_.bytes() + areas_.bytes();
  for (const auto& links : links_) bytes += links.capacity() * sizeof(NormalLink);
  return bytes;
}

size_t SideTree::ScratchBytes(size_t point_count) {
  const size_t points = std::min(point_count, kChunkPoints), links = points * (kLinksPerPoint + 1);
  const SearchPlan search = SearchPlan::ByCount(std::min(kLinksPerPoint + 1, point_count));
  return sizeof(LinkScratch) + sizeof(ForestScratch) + SearchScratchBytes(search, point_count) +
         ScratchArray<NormalLink>::MostBytes(links) + ScratchArray<uint32_t>::MostBytes(links) +
         ScratchArray<uint32_t>::MostBytes(points + links);
}

}  // namespace curvd
