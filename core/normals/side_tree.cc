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

absl::StatusOr<size_t> SideTree::Link(size_t first, LinkScratch& scratch, ForestScratch& forest) {
  const size_t chunk = first / kChunkPoints, begin = chunk * kChunkPoints, last = ChunkEnd(chunk);
  std::vector<NormalLink>& kept_links = links_[chunk];
  scratch.link_count = kept_links.size();  // of the points before
  scratch.links.Reserve(scratch.link_count);
  std::copy(kept_links.begin(), kept_links.end(), scratch.links.data());
  const uint64_t began = scratch.work();
  size_t next = first;
  while (next < last && scratch.work() - began <= WorkerScratch::kMostRunWork) {
    const size_t group = next / SpatialIndex::kGroupPoints;
    scratch.first_point = next % SpatialIndex::kGroupPoints;
    scratch.rest = 0;
    const absl::Status status = AppendLinks(index_, plan_, group, scratch, areas_.data());
    if (!status.ok()) return status;
    next = scratch.rest > 0 ? group * SpatialIndex::kGroupPoints + scratch.rest
                            : std::min((group + 1) * SpatialIndex::kGroupPoints, last);
  }
  NormalLink* const links = scratch.links.data();
  const size_t kept =
      KeepForest(links, scratch.link_count, static_cast<uint32_t>(begin), static_cast<uint32_t>(last), forest);
  // More than two links a point have nearly all their ends in other chunks; the dearest of those are given up.
  kept_links.assign(links, links + (next == last ? std::min(kept, kMostKept) : kept));
  for (size_t place = first; place < next; ++place) StartPlace(place);
  return next == last ? kNoRest : next;
}

void SideTree::StartPlace(size_t place) {
  const float x = index_.normals(place / SpatialIndex::kLeafSize).x[place % SpatialIndex::kLeafSize];
  parents_[place] = x == x ? Join(static_cast<uint32_t>(place), 0) : kNone;
  offers_[place] = kNoLink;
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
