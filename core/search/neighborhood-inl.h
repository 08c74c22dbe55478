// Who is inside a neighborhood: the steps that find it by vector scans, and the one loop that reads it.

// Toggled so that each instruction set compiles its own copy.
#if defined(CURVD_CORE_SEARCH_NEIGHBORHOOD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_SEARCH_NEIGHBORHOOD_INL_H_
#undef CURVD_CORE_SEARCH_NEIGHBORHOOD_INL_H_
#else
#define CURVD_CORE_SEARCH_NEIGHBORHOOD_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/index/vectors-inl.h"
#include "core/search/gather_leaves-inl.h"
#include "core/search/search_scratch.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// The same operations in the same order on every instruction set and in scalar code: neighbor sets must agree.
HWY_INLINE FloatVec SquaredNorm(FloatVec x, FloatVec y, FloatVec z) {
  return hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
}

HWY_INLINE FloatVec DistanceOutside(FloatVec q, FloatVec lo, FloatVec hi) {
  return hn::Max(hn::Max(hn::Sub(lo, q), hn::Sub(q, hi)), hn::Zero(FloatTag()));
}

// A query in all lanes.
struct QueryVectors {
  explicit HWY_INLINE QueryVectors(const float* query)
      : x(hn::Set(FloatTag(), query[0])), y(hn::Set(FloatTag(), query[1])), z(hn::Set(FloatTag(), query[2])) {}
  FloatVec x, y, z;
};

// Squared distances from the query to points i, i + 1, ... of a leaf.
HWY_INLINE FloatVec SquaredDistances(const QueryVectors& query, const SpatialIndex::LeafPositions& points, size_t i) {
  const FloatTag d;
  return SquaredNorm(hn::Sub(hn::Load(d, points.x + i), query.x), hn::Sub(hn::Load(d, points.y + i), query.y),
                     hn::Sub(hn::Load(d, points.z + i), query.z));
}

// Which of points with these squared distances and ids have at most the rank `last`. Ids decide, at its distance, if
// kSplitsTies.
template <bool kSplitsTies>
HWY_INLINE FloatMask Inside(FloatVec squared, const int32_t* ids, const NeighborRank& last) {
  const FloatTag d;
  const IntTag di;
  const FloatVec limit = hn::Set(d, last.squared_distance);
  const FloatMask inside = hn::Le(squared, limit);
  if constexpr (!kSplitsTies) return inside;
  const FloatMask late = hn::RebindMask(d, hn::Gt(hn::Load(di, ids), hn::Set(di, last.id)));
  return hn::AndNot(hn::And(late, hn::Eq(squared, limit)), inside);
}

// A vector of points of a leaf that may hold neighbors.
struct NearPoints {
  uint32_t leaf;      // of the index
  uint32_t position;  // of the leaf in the list that was searched
  size_t near;        // which of Neighborhood::leaves it is
  size_t place;       // of the first of the points in the leaf
  FloatVec squared;   // distances from the query
};

template <bool kSplitsTies, typename Visit>
HWY_INLINE float ForEachInside(const SpatialIndex& index, const Neighborhood& found, Visit& visit) {
  const FloatTag d;
  constexpr size_t kLeaf = SpatialIndex::kLeafSize;
  // Copies, since what visits store might lie anywhere, for all that the compiler knows.
  const size_t leaf_count = found.leaf_count;
  const NeighborRank last = found.last;
  const uint32_t* const leaves = found.leaves.data();
  const uint32_t* const positions = found.positions.data();
  const float* const squared_distances = found.squared_distances.data();
  FloatVec farthest = hn::Zero(d);
  for (size_t j = 0; j < leaf_count; ++j) {
    const uint32_t leaf = leaves[j];
    for (size_t i = 0; i < kLeaf; i += hn::Lanes(d)) {
      const FloatVec squared = hn::Load(d, squared_distances + j * kLeaf + i);
      const FloatMask inside = Inside<kSplitsTies>(squared, index.positions(leaf).id + i, last);
      farthest = hn::Max(farthest, hn::IfThenElseZero(inside, squared));
      visit(NearPoints{leaf, positions[j], j, i, squared}, inside);
    }
  }
  return hn::GetLane(hn::MaxOfLanes(d, farthest));
}

// Calls `visit(points, inside)` for each vector of points that may hold neighbors, in tree order, with the mask of
// those that are; the mask may be empty. Returns the largest squared distance of a neighbor, 0 if there is none. This
// is the only place that decides who is inside. A visit must be inlined: mark it HWY_INLINE, or a lambda CURVD_INLINED.
#define CURVD_INLINED HWY_ATTR __attribute__((always_inline))
template <typename Visit>
HWY_INLINE float ForEachInside(const SpatialIndex& index, const Neighborhood& found, Visit& visit) {
  return found.last.id == SpatialIndex::kPaddingId ? ForEachInside<false>(index, found, visit)
                                                   : ForEachInside<true>(index, found, visit);
}

// Lists the leaves whose box meets the closed ball around `query`, and where they are in `leaves`.
HWY_INLINE void CullLeaves(const LeafList& leaves, const float* query, float squared_radius, Neighborhood& found) {
  const FloatTag d;
  const IntTag di;
  found.leaves.Reserve(leaves.padded_size() + LeafList::kPad);
  found.positions.Reserve(leaves.padded_size() + LeafList::kPad);
  auto* near = reinterpret_cast<int32_t*>(found.leaves.data());
  auto* positions = reinterpret_cast<int32_t*>(found.positions.data());
  const QueryVectors q(query);
  const FloatVec limit = hn::Set(d, squared_radius);
  size_t count = 0;
  for (size_t i = 0; i < leaves.size(); i += hn::Lanes(d)) {
    const FloatVec x = DistanceOutside(q.x, hn::Load(d, leaves.lo(0) + i), hn::Load(d, leaves.hi(0) + i));
    const FloatVec y = DistanceOutside(q.y, hn::Load(d, leaves.lo(1) + i), hn::Load(d, leaves.hi(1) + i));
    const FloatVec z = DistanceOutside(q.z, hn::Load(d, leaves.lo(2) + i), hn::Load(d, leaves.hi(2) + i));
    const auto meets = hn::RebindMask(di, hn::Le(SquaredNorm(x, y, z), limit));
    const auto leaf = hn::Load(di, reinterpret_cast<const int32_t*>(leaves.leaves()) + i);
    hn::StoreU(hn::Compress(leaf, meets), di, near + count);
    hn::StoreU(hn::Compress(IntsFrom(static_cast<int32_t>(i)), meets), di, positions + count);
    count += hn::CountTrue(di, meets);
  }
  found.leaf_count = count;
}

// What squared distances lie in: (low, high]. A low of kNoLow leaves out none.
struct DistanceRange {
  static constexpr float kNoLow = -1.0f;
  float low, high;
};

// The share by which to widen what is guessed of the squared radius of a neighborhood of `count` points: those of
// neighborhoods side by side differ by a share that falls with the root of their size. Within 1.4 over that root lie
// all but one in 4 of those of 15 neighbors, in 8 of 50, in 50 of 300.
HWY_INLINE float GuessGrowth(size_t count) {
  return 1.0f + 1.4f / std::sqrt(static_cast<float>(std::max<size_t>(count, 1)));
}

// How many points lie nearer than a range of distances, and within it.
struct DistanceCounts {
  size_t below, inside;
};

// Measures the distances from `query` to the points of the culled leaves. Those in the range also go to
// `inner_distances`, padded with infinity to a whole vector.
HWY_INLINE DistanceCounts MeasureDistances(const SpatialIndex& index, const float* query, const DistanceRange& range,
                                           Neighborhood& found, ScratchArray<float>& inner_distances) {
  const FloatTag d;
  constexpr size_t kLeaf = SpatialIndex::kLeafSize;
  found.squared_distances.Reserve(found.leaf_count * kLeaf);
  inner_distances.Reserve(found.leaf_count * kLeaf + 2 * kLeaf);
  const QueryVectors q(query);
  const FloatVec low = hn::Set(d, range.low), high = hn::Set(d, range.high);
  float* inner = inner_distances.data();
  size_t below = 0;
  for (size_t j = 0; j < found.leaf_count; ++j) {
    const SpatialIndex::LeafPositions& points = index.positions(found.leaves[j]);
    float* out = found.squared_distances.data() + j * kLeaf;
    for (size_t i = 0; i < kLeaf; i += hn::Lanes(d)) {
      const FloatVec squared = SquaredDistances(q, points, i);
      hn::Store(squared, d, out + i);
      const FloatMask is_below = hn::Le(squared, low);
      const FloatMask inside = hn::AndNot(is_below, hn::Le(squared, high));
      below += hn::CountTrue(d, is_below);
      hn::StoreU(hn::Compress(squared, inside), d, inner);
      inner += hn::CountTrue(d, inside);
    }
  }
  hn::StoreU(hn::Set(d, std::numeric_limits<float>::infinity()), d, inner);
  return {below, static_cast<size_t>(inner - inner_distances.data())};
}

// Numbers of values <= each of three limits, which are given by their bits. REQUIRES: padded with infinity to a whole
// vector.
HWY_INLINE void CountAtMost(const float* values, size_t size, const int32_t (&limit_bits)[3], size_t (&counts)[3]) {
  const FloatTag d;
  const auto limit = [&limit_bits, d](int m) HWY_ATTR { return hn::Set(d, std::bit_cast<float>(limit_bits[m])); };
  const FloatVec first = limit(0), second = limit(1), third = limit(2);
  size_t at_first = 0, at_second = 0, at_third = 0;
  for (size_t i = 0; i < size; i += hn::Lanes(d)) {
    const FloatVec v = hn::Load(d, values + i);
    at_first += hn::CountTrue(d, hn::Le(v, first));
    at_second += hn::CountTrue(d, hn::Le(v, second));
    at_third += hn::CountTrue(d, hn::Le(v, third));
  }
  counts[0] = at_first;
  counts[1] = at_second;
  counts[2] = at_third;
}

// A limit at which at least k of some values lie: exactly k, or the lowest where ties leave no such limit.
struct CountedLimit {
  float limit;
  size_t count;  // values <= limit
  size_t below;  // values < limit, if count > k
};

// Narrows the limit by counts: nothing is sorted and no branch depends on one value. The first steps interpolate
// (points of a surface are even in squared distance), and count at three limits, a value apart, since each step waits
// for the one before it; later ones halve the float's bits, so that ties end it. `below` further values are at most
// range.low. REQUIRES: below < k <= below + size; the values lie in the range; none is negative.
HWY_INLINE CountedLimit LimitByCounting(const float* values, size_t size, size_t below, size_t k,
                                        const DistanceRange& range) {
  constexpr int kInterpolations = 8;
  int32_t low_bits = range.low < 0.0f ? -1 : std::bit_cast<int32_t>(range.low);  // below the bits of every value
  int32_t high_bits = std::bit_cast<int32_t>(range.high);
  size_t low_count = below;
  size_t high_count = below + size;
  for (int step = 0; high_count != k; ++step) {
    const float low_value = low_bits < 0 ? 0.0f : std::bit_cast<float>(low_bits);
    const float high_value = std::bit_cast<float>(high_bits);
    const float gap = (high_value - low_value) / (static_cast<float>(high_count - low_count) + 1.0f);
    const auto missing = static_cast<float>(k - low_count);
    int32_t middle[3];
    for (int m = 0; m < 3; ++m) {
      middle[m] = std::bit_cast<int32_t>(low_value + gap * (missing + (static_cast<float>(m) - 0.5f)));
    }
    if (step >= kInterpolations || middle[0] <= low_bits || middle[2] >= high_bits) {
      middle[0] = middle[1] = middle[2] = low_bits + (high_bits - low_bits) / 2;
      if (middle[0] == low_bits) break;  // all values between the counts are equal
    }
    size_t count[3];
    CountAtMost(values, size, middle, count);
    for (size_t& of_limit : count) of_limit += below;
    for (int m = 0; m < 3; ++m) {
      const bool is_low = count[m] < k;
      low_bits = is_low ? middle[m] : low_bits;
      low_count = is_low ? count[m] : low_count;
    }
    for (int m = 2; m >= 0; --m) {
      const bool is_high = count[m] >= k;
      high_bits = is_high ? middle[m] : high_bits;
      high_count = is_high ? count[m] : high_count;
    }
  }
  return {std::bit_cast<float>(high_bits), high_count, low_count};
}

HWY_INLINE CountedLimit LimitByCounting(const float* values, size_t size, size_t k, float high) {
  return LimitByCounting(values, size, 0, k, {DistanceRange::kNoLow, high});
}

// Of more than k points at most at a limit, the rank of the k-th: ties go to the lowest ids.
HWY_NOINLINE inline NeighborRank SplitTies(const SpatialIndex& index, const CountedLimit& counted, size_t k,
                                           const Neighborhood& found, ScratchArray<int32_t>& tied_ids) {
  constexpr size_t kLeaf = SpatialIndex::kLeafSize;
  size_t tied = 0;
  for (size_t i = 0; i < found.leaf_count * kLeaf; ++i) {
    if (found.squared_distances[i] != counted.limit) continue;
    tied_ids.Reserve(tied + 1);
    tied_ids[tied++] = index.positions(found.leaves[i / kLeaf]).id[i % kLeaf];
  }
  int32_t* last = tied_ids.data() + (k - counted.below - 1);
  std::nth_element(tied_ids.data(), last, tied_ids.data() + tied);
  return {counted.limit, *last};
}

// Adds what the last search of a list took to the work: a step for each leaf of the list, and one for each point of the
// leaves that meet the ball, though those are read several times: measured once, counted at most 40 times
// (LimitByCounting), and shown to visitors.
HWY_INLINE void CountWork(const LeafList& leaves, SearchScratch& s) {
  s.work += leaves.size() + s.found.leaf_count * SpatialIndex::kLeafSize;
}

// Finds the K nearest points in the listed leaves, which hold every point within `squared_reach`. Returns false if
// fewer than K points are that near. `guess` only seeds: where the K-th distance lies in it, all is read once. Counts
// the work of all passes over the list but that of the one that finds them, which is left to the caller.
HWY_INLINE bool NearestInReach(const SpatialIndex& index, const LeafList& leaves, const float* query, size_t k,
                               const DistanceRange& guess, float squared_reach, SearchScratch& s) {
  DistanceRange range{std::min(guess.low, squared_reach), std::min(guess.high, squared_reach)};
  while (true) {
    CullLeaves(leaves, query, range.high, s.found);
    const DistanceCounts counts = MeasureDistances(index, query, range, s.found, s.inner_distances);
    if (HWY_UNLIKELY(counts.below >= k)) {
      range = {DistanceRange::kNoLow, range.low};
    } else if (counts.below + counts.inside < k) {
      if (range.high == squared_reach) break;
      range = {range.high, squared_reach};
    } else {
      const CountedLimit counted = LimitByCounting(s.inner_distances.data(), counts.inside, counts.below, k, range);
      s.found.count = k;
      s.found.last = {counted.limit, SpatialIndex::kPaddingId};
      if (counted.count != k) s.found.last = SplitTies(index, counted, k, s.found, s.tied_ids);
      return true;
    }
    CountWork(leaves, s);
  }
  CountWork(leaves, s);
  return false;
}

// Measures the distances to the points of a leaf, and keeps the leaf if one of them has at most the rank `found.last`.
HWY_INLINE void KeepIfInside(const SpatialIndex& index, uint32_t leaf, const QueryVectors& query, SearchScratch& s) {
  const FloatTag d;
  constexpr size_t kLeaf = SpatialIndex::kLeafSize;
  Neighborhood& found = s.found;
  const SpatialIndex::LeafPositions& points = index.positions(leaf);
  found.squared_distances.Reserve((found.leaf_count + 1) * kLeaf);
  float* out = found.squared_distances.data() + found.leaf_count * kLeaf;
  size_t members = 0;
  for (size_t i = 0; i < kLeaf; i += hn::Lanes(d)) {
    const FloatVec squared = SquaredDistances(query, points, i);
    hn::Store(squared, d, out + i);
    members += hn::CountTrue(d, Inside<true>(squared, points.id + i, found.last));
  }
  if (members == 0) return;
  found.leaves.Reserve(found.leaf_count + 1);
  found.positions.Reserve(found.leaf_count + 1);
  found.leaves[found.leaf_count] = leaf;
  found.positions[found.leaf_count] = static_cast<uint32_t>(found.leaf_count);
  ++found.leaf_count;
  found.count += members;
  s.query_leaves.Add(index, leaf);
}

// Finds the points of at most the rank `last` by a descent of the tree, for any surroundings, and lists the leaves with
// such points as `s.query_leaves`. Ends once they are more than `max_count`: returns false, with s.found.count above
// it. Ends between leaves, with some of the points found, once `s` is stopped.
HWY_NOINLINE inline bool FindByDescent(const SpatialIndex& index, const float* query, const NeighborRank& last,
                                       size_t max_count, SearchScratch& s) {
  const FloatTag d;
  s.found.last = last;
  s.found.count = s.found.leaf_count = 0;
  s.query_leaves.Clear();
  const QueryVectors q(query);
  const ReachTest meets({{query[0], query[1], query[2]}, {query[0], query[1], query[2]}}, last.squared_distance);
  const auto enters = [&](const TreeNode& node) {
    return !(last < NeighborRank{SquaredDistance(query, node.box), node.min_id});
  };
  size_t tested = 0, measured = 0;
  const size_t entered = WalkLeaves(index, enters, [&](uint32_t first, uint32_t count) HWY_ATTR {
    tested += count;
    for (uint32_t i = 0; i < count; i += static_cast<uint32_t>(hn::Lanes(d))) {
      const FloatMask near = hn::And(meets.LeavesFrom(index, first + i), hn::FirstN(d, count - i));
      for (uint64_t bits = BitsFromMask(near); bits != 0; bits &= bits - 1) {
        ++measured;
        KeepIfInside(index, first + i + static_cast<uint32_t>(std::countr_zero(bits)), q, s);
        if (s.found.count > max_count) return false;
      }
    }
    return !s.IsStopped();
  });
  s.work += entered + tested + measured * SpatialIndex::kLeafSize;
  s.query_leaves.Pad();
  return s.found.count <= max_count;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_SEARCH_NEIGHBORHOOD_INL_H_
