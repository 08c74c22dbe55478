#include "core/normals/orientation/side_tree.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <numeric>
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
  if (!created.ok()) return created.status();
  array = *std::move(created);
  return absl::OkStatus();
}

}  // namespace

size_t SideTree::ChunkEnd(size_t chunk) const { return std::min((chunk + 1) * kChunkPoints, index_.point_count()); }

absl::Status SideTree::Start() {
  const size_t points = index_.point_count();
  links_.resize(chunk_count());
  roots_.resize(chunk_count() * kChunkWords);
  least_points_ = static_cast<uint32_t>(std::max(kLeastCluster, points / kMostLargeClusters));
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
  std::sort(scratch.links.data(), scratch.links.data() + scratch.link_count,
            [](const NormalLink& x, const NormalLink& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
  scratch.first_reach = first;
  scratch.reaches.Reserve(kChunkPoints);
  const uint64_t began = scratch.work();
  size_t next = first;
  do {
    const size_t group = next / SpatialIndex::kGroupPoints;
    scratch.first_point = next % SpatialIndex::kGroupPoints;
    scratch.rest = 0;
    const absl::Status status = AppendLinks(index_, plan_, group, scratch, areas_.data());
    if (!status.ok()) return status;
    next = scratch.rest > 0 ? group * SpatialIndex::kGroupPoints + scratch.rest
                            : std::min((group + 1) * SpatialIndex::kGroupPoints, last);
  } while (next < last && scratch.work() - began <= WorkerScratch::kMostRunWork && scratch.link_count < kManyLinks);
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
  const bool is_root = x == x;
  parents_[place] = is_root ? Join(static_cast<uint32_t>(place), 0) : kNone;
  if (is_root) roots_[place / kWordBits] |= uint64_t{1} << place % kWordBits;
  offers_[place] = kNoLink;
  pieces_[place] = 1;
}

bool SideTree::BeginRound() {
  if (stage_ == Stage::kStart) {
    stage_ = Stage::kCertain;
  } else if (joined_ == 0) {
    stage_ = stage_ == Stage::kCertain ? Stage::kUncertain : Stage::kDone;
  }
  joined_ = 0;
  return stage_ != Stage::kDone;
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
  for (NormalLink link : links) {
    // The ends were roots when the round before began, and know the roots of now.
    const uint32_t a = parents_[link.a], b = parents_[link.b];
    if (a >> 1 == b >> 1) continue;
    link.a = a >> 1;
    link.b = b >> 1;
    link.opposite ^= (a ^ b) & 1;
    const uint64_t name = chunk << kLinkBits | kept;
    const uint64_t offer = uint64_t{std::bit_cast<uint32_t>(link.cost)} << 32 | name;
    links[kept++] = link;
    const bool is_certain = link.cost <= kCertain;
    if (stage_ == Stage::kCertain && !is_certain) continue;
    if (is_certain || IsSmall(link.a)) Offer(link.a, offer);
    if (is_certain || IsSmall(link.b)) Offer(link.b, offer);
  }
  links.resize(kept);
}

// Calls use(root) for each root of the chunk, in ascending order; it may stop being one meanwhile.
template <typename Use>
void SideTree::ForEachRoot(size_t chunk, const Use& use) {
  for (size_t word = chunk * kChunkWords; word < (chunk + 1) * kChunkWords; ++word) {
    for (uint64_t left = roots_[word]; left != 0; left &= left - 1) {
      use(static_cast<uint32_t>(word * kWordBits + static_cast<size_t>(std::countr_zero(left))));
    }
  }
}

void SideTree::Follow(size_t chunk) {
  size_t joined = 0;
  ForEachRoot(chunk, [&](uint32_t root) {
    uint32_t target = Join(root, 0);
    if (offers_[root] != kNoLink) {
      const auto name = static_cast<uint32_t>(offers_[root]);
      const NormalLink& link = links_[name >> kLinkBits][name & (kMostKept - 1)];
      const uint32_t other = link.a == root ? link.b : link.a;
      // Large clusters follow nothing that is uncertain, so that what follows them closes no circle.
      const bool follows_large = stage_ == Stage::kUncertain && !IsSmall(other);
      if (follows_large || RankOf(other) < RankOf(root)) target = Join(other, link.opposite);
    }
    offers_[root] = target;
    joined += target >> 1 != root ? 1 : 0;
  });
  joined_ += joined;
}

// The root that `root` comes to by following, and the side relative to it.
uint32_t SideTree::TargetOf(uint32_t root) const {
  uint32_t opposite = 0;
  for (auto next = static_cast<uint32_t>(offers_[root]); next >> 1 != root;
       next = static_cast<uint32_t>(offers_[root])) {
    root = next >> 1;
    opposite ^= next & 1;
  }
  return Join(root, opposite);
}

void SideTree::Flatten(size_t chunk) {
  ForEachRoot(chunk, [this](uint32_t root) {
    parents_[root] = TargetOf(root);
    if (IsRoot(root)) return;
    std::atomic_ref<uint32_t>(pieces_[parents_[root] >> 1]).fetch_add(pieces_[root], std::memory_order_relaxed);
  });
}

void SideTree::EndRound(size_t chunk) {
  ForEachRoot(chunk, [this](uint32_t root) {
    offers_[root] = kNoLink;
    if (!IsRoot(root)) roots_[root / kWordBits] ^= uint64_t{1} << root % kWordBits;
  });
}

// Others may do the same with what this one reads: each value names a place nearer to the root, and the side to it.
void SideTree::FlattenPlaces(size_t chunk) {
  for (size_t place = chunk * kChunkPoints; place < ChunkEnd(chunk); ++place) {
    const std::atomic_ref<uint32_t> own(parents_[place]);
    uint32_t at = own.load(std::memory_order_relaxed);
    if (at == kNone) continue;
    for (;;) {
      const uint32_t next = std::atomic_ref<uint32_t>(parents_[at >> 1]).load(std::memory_order_relaxed);
      if (next >> 1 == at >> 1) break;
      at = next ^ (at & 1);
    }
    own.store(at, std::memory_order_relaxed);
  }
}

void SideTree::NumberClusters() {
  for (size_t chunk = 0; chunk < chunk_count(); ++chunk) {
    ForEachRoot(chunk, [this](uint32_t root) {
      const auto number = static_cast<uint32_t>(clusters_.size());
      clusters_.push_back({root, pieces_[root], number, false});
      pieces_[root] = number;
    });
  }
  roots_ = {};
}

void SideTree::JoinClusters() {
  offers_ = {};
  NumberClusters();
  std::vector<NormalLink> left;
  for (std::vector<NormalLink>& links : links_) {
    left.insert(left.end(), links.begin(), links.end());
    links = {};
  }
  links_ = {};
  // They come in the order of the places at which they began: what remains of ComesBefore.
  std::vector<uint32_t> order(left.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&left](uint32_t x, uint32_t y) {
    return left[x].cost != left[y].cost ? left[x].cost < left[y].cost : x < y;
  });
  // A cluster's `piece` is first another cluster of the same piece, of a lower number, or itself.
  const auto find = [this](uint32_t cluster) {
    uint32_t opposite = 0;
    while (clusters_[cluster].piece != cluster) {
      opposite ^= clusters_[cluster].is_opposite ? 1 : 0;
      cluster = clusters_[cluster].piece;
    }
    return Join(cluster, opposite);
  };
  for (const uint32_t i : order) {
    const NormalLink& link = left[i];
    const uint32_t a = find(cluster(link.a)), b = find(cluster(link.b));
    if (a >> 1 == b >> 1) continue;
    const uint32_t sides = (a ^ b ^ link.opposite ^ parents_[link.a] ^ parents_[link.b]) & 1;
    Cluster& later = clusters_[std::max(a >> 1, b >> 1)];
    later.piece = std::min(a >> 1, b >> 1);
    later.is_opposite = sides != 0;
  }
  for (uint32_t i = 0; i < clusters_.size(); ++i) {
    Cluster& cluster = clusters_[i];
    if (cluster.piece == i) {
      cluster.piece = static_cast<uint32_t>(piece_count_++);
      continue;
    }
    // Those before are done: their `piece` is a number, and their side that of the whole way.
    const Cluster& before = clusters_[cluster.piece];
    cluster.piece = before.piece;
    cluster.is_opposite = cluster.is_opposite != before.is_opposite;
  }
}

void SideTree::Clear() {
  links_ = {};
  roots_ = {};
  parents_ = {};
  offers_ = {};
  pieces_ = {};
  areas_ = {};
  clusters_ = {};
}

size_t SideTree::bytes() const {
  size_t bytes =
      parents_.bytes() + offers_.bytes() + pieces_.bytes() + areas_.bytes() + clusters_.capacity() * sizeof(Cluster);
  for (const auto& links : links_) bytes += links.capacity() * sizeof(NormalLink);
  return bytes + roots_.capacity() * sizeof(uint64_t);
}

size_t SideTree::ScratchBytes(size_t point_count) {
  const size_t points = std::min(point_count, kChunkPoints), most = std::min(kMostLinksPerPoint + 1, point_count);
  const size_t links = std::min(points * most, kManyLinks + SpatialIndex::kGroupPoints * most);
  const SearchPlan search = SearchPlan::ByCount(most);
  return sizeof(LinkScratch) + sizeof(ForestScratch) + SearchScratchBytes(search, point_count) +
         ScratchArray<NormalLink>::MostBytes(links) + ScratchArray<float>::MostBytes(kChunkPoints) +
         ForestScratch::MostBytes(points, links);
}

}  // namespace curvd
