// Exact neighborhoods by vector scans: cull leaves, measure distances, find the K-th by counting, collect.

// Toggled so that each instruction set compiles its own copy.
#if defined(CURVD_CORE_SEARCH_NEIGHBORHOOD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_SEARCH_NEIGHBORHOOD_INL_H_
#undef CURVD_CORE_SEARCH_NEIGHBORHOOD_INL_H_
#else
#define CURVD_CORE_SEARCH_NEIGHBORHOOD_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <limits>

#include "core/estimators/group_buffers.h"
#include "core/index/vectors-inl.h"
#include "core/search/gather_leaves-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Which points belong to a neighborhood: those below `limit`, and of those at `limit` the ids up to `last_id`.
struct Cutoff {
  float limit;
  int32_t last_id = std::numeric_limits<int32_t>::max();

  bool splits_ties() const { return last_id != std::numeric_limits<int32_t>::max(); }
};

// The same operations in the same order on every instruction set and in scalar code: neighbor sets must agree.
HWY_INLINE FloatVec SquaredNorm(FloatVec x, FloatVec y, FloatVec z) {
  return hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
}

HWY_INLINE FloatVec DistanceOutside(FloatVec q, FloatVec lo, FloatVec hi) {
  return hn::Max(hn::Max(hn::Sub(lo, q), hn::Sub(q, hi)), hn::Zero(FloatTag()));
}

// Lists the leaves whose box meets the closed ball around `query` as `b.near`, and where they are in `leaves` as
// `b.near_positions`; returns their number.
HWY_INLINE size_t CullLeaves(const LeafList& leaves, const float* query, float squared_radius,
                             GroupScratch::Buffers& b) {
  const FloatTag d;
  const IntTag di;
  b.near.Reserve(leaves.padded_size() + LeafList::kPad);
  b.near_positions.Reserve(leaves.padded_size() + LeafList::kPad);
  auto* near = reinterpret_cast<int32_t*>(b.near.data());
  auto* positions = reinterpret_cast<int32_t*>(b.near_positions.data());
  const FloatVec qx = hn::Set(d, query[0]), qy = hn::Set(d, query[1]), qz = hn::Set(d, query[2]);
  const FloatVec limit = hn::Set(d, squared_radius);
  size_t count = 0;
  for (size_t i = 0; i < leaves.size(); i += hn::Lanes(d)) {
    const FloatVec x = DistanceOutside(qx, hn::Load(d, leaves.lo(0) + i), hn::Load(d, leaves.hi(0) + i));
    const FloatVec y = DistanceOutside(qy, hn::Load(d, leaves.lo(1) + i), hn::Load(d, leaves.hi(1) + i));
    const FloatVec z = DistanceOutside(qz, hn::Load(d, leaves.lo(2) + i), hn::Load(d, leaves.hi(2) + i));
    const auto meets = hn::RebindMask(di, hn::Le(SquaredNorm(x, y, z), limit));
    const auto leaf = hn::Load(di, reinterpret_cast<const int32_t*>(leaves.leaves()) + i);
    hn::StoreU(hn::Compress(leaf, meets), di, near + count);
    hn::StoreU(hn::Compress(hn::Iota(di, static_cast<int32_t>(i)), meets), di, positions + count);
    count += hn::CountTrue(di, meets);
  }
  return count;
}

// Squared distances from `query` to the points of the listed leaves. Those within the ball also go to
// `inner_distances`, padded with infinity to a whole vector; returns their number.
HWY_INLINE size_t MeasureDistances(const SpatialIndex& index, const float* query, float squared_radius,
                                   size_t near_count, GroupScratch::Buffers& b) {
  const FloatTag d;
  constexpr size_t kLeaf = SpatialIndex::kLeafSize;
  b.squared_distances.Reserve(near_count * kLeaf);
  b.inner_distances.Reserve(near_count * kLeaf + 2 * kLeaf);
  const FloatVec qx = hn::Set(d, query[0]), qy = hn::Set(d, query[1]), qz = hn::Set(d, query[2]);
  const FloatVec limit = hn::Set(d, squared_radius);
  float* inner = b.inner_distances.data();
  for (size_t j = 0; j < near_count; ++j) {
    const SpatialIndex::LeafPositions& points = index.positions(b.near[j]);
    float* out = b.squared_distances.data() + j * kLeaf;
    for (size_t i = 0; i < kLeaf; i += hn::Lanes(d)) {
      const FloatVec squared =
          SquaredNorm(hn::Sub(hn::Load(d, points.x + i), qx), hn::Sub(hn::Load(d, points.y + i), qy),
                      hn::Sub(hn::Load(d, points.z + i), qz));
      hn::Store(squared, d, out + i);
      const FloatMask inside = hn::Le(squared, limit);
      hn::StoreU(hn::Compress(squared, inside), d, inner);
      inner += hn::CountTrue(d, inside);
    }
  }
  hn::StoreU(hn::Set(d, std::numeric_limits<float>::infinity()), d, inner);
  return inner - b.inner_distances.data();
}

// Number of values <= limit. REQUIRES: padded with infinity to a whole vector.
HWY_INLINE size_t CountAtMost(const float* values, size_t size, float limit) {
  const FloatTag d;
  const FloatVec bound = hn::Set(d, limit);
  size_t count = 0;
  for (size_t i = 0; i < size; i += hn::Lanes(d)) count += hn::CountTrue(d, hn::Le(hn::Load(d, values + i), bound));
  return count;
}

// The lowest limit at which at least k of the values lie, unless exactly k lie below a higher one.
// `at_most_below` is the number of values below the limit, for when more than k lie at most at it.
struct CountedLimit {
  float limit;
  size_t count;  // values <= limit
  size_t below;  // values < limit, if count > k
};

// Bisects the limit on the count: nothing is sorted and no branch depends on one value. The first steps interpolate
// (points of a surface are even in squared distance), later ones halve the float's bits, so that ties end it.
// REQUIRES: k >= 1, at least k values are <= high; none is negative.
HWY_INLINE CountedLimit LimitByCounting(const float* values, size_t size, size_t k, float high) {
  constexpr int kInterpolations = 8;
  int32_t low_bits = -1;  // below the bits of every value
  int32_t high_bits = std::bit_cast<int32_t>(high);
  size_t low_count = 0;
  size_t high_count = size;
  for (int step = 0; high_count != k; ++step) {
    const float low_value = low_bits < 0 ? 0.0f : std::bit_cast<float>(low_bits);
    const float high_value = std::bit_cast<float>(high_bits);
    const float fraction =
        (static_cast<float>(k - low_count) + 0.5f) / (static_cast<float>(high_count - low_count) + 1);
    int32_t middle = std::bit_cast<int32_t>(low_value + (high_value - low_value) * fraction);
    if (step >= kInterpolations || middle <= low_bits || middle >= high_bits) {
      middle = low_bits + (high_bits - low_bits) / 2;
      if (middle == low_bits) break;  // all values between the counts are equal
    }
    const size_t count = CountAtMost(values, size, std::bit_cast<float>(middle));
    (count < k ? low_bits : high_bits) = middle;
    (count < k ? low_count : high_count) = count;
  }
  return {std::bit_cast<float>(high_bits), high_count, low_count};
}

// Turns a limit with ties into a cutoff that keeps the lowest ids.
HWY_NOINLINE inline Cutoff SplitTies(const SpatialIndex& index, const CountedLimit& counted, size_t k,
                                     size_t near_count, GroupScratch::Buffers& b) {
  b.tied_ids.clear();
  for (size_t i = 0; i < near_count * SpatialIndex::kLeafSize; ++i) {
    if (b.squared_distances[i] != counted.limit) continue;
    b.tied_ids.push_back(index.positions(b.near[i / SpatialIndex::kLeafSize]).id[i % SpatialIndex::kLeafSize]);
  }
  const auto last = b.tied_ids.begin() + (k - counted.below - 1);
  std::nth_element(b.tied_ids.begin(), last, b.tied_ids.end());
  return {counted.limit, *last};
}

// Which of the points i, i + 1, ... of a leaf, at these squared distances, lie inside the cutoff.
template <bool kSplitsTies>
HWY_INLINE FloatMask Inside(const SpatialIndex& index, size_t leaf, size_t i, FloatVec squared, const Cutoff& cutoff) {
  const FloatTag d;
  const IntTag di;
  const FloatVec limit = hn::Set(d, cutoff.limit);
  const FloatMask inside = hn::Le(squared, limit);
  if constexpr (!kSplitsTies) return inside;
  const auto id = hn::Load(di, index.positions(leaf).id + i);
  const FloatMask early = hn::RebindMask(d, hn::Lt(id, hn::Set(di, cutoff.last_id + 1)));
  return hn::And(inside, hn::Or(early, hn::Lt(squared, limit)));
}

HWY_INLINE void StoreSums(FloatVec x, FloatVec y, FloatVec z, float sums[3]) {
  float four[4];
  StoreFourSums(x, y, z, hn::Zero(FloatTag()), four);
  std::copy(four, four + 3, sums);
}

// Sums the neighbors' normals; padding adds nothing.
HWY_INLINE void SumNormals(NeighborArrays& n) {
  const FloatTag d;
  FloatVec x = hn::Zero(d), y = hn::Zero(d), z = hn::Zero(d);
  for (size_t j = 0; j < n.count; j += hn::Lanes(d)) {
    x = hn::Add(x, hn::Load(d, n.nx.data() + j));
    y = hn::Add(y, hn::Load(d, n.ny.data() + j));
    z = hn::Add(z, hn::Load(d, n.nz.data() + j));
  }
  StoreSums(x, y, z, n.normal_sum);
}

// Collects the points inside the cutoff as neighbors of `query`, in tree order, padded with zeros to a whole vector.
// Returns the largest squared distance.
template <bool kSplitsTies>
HWY_INLINE float CollectNeighbors(const SpatialIndex& index, const float* query, const Cutoff& cutoff, size_t count,
                                  size_t near_count, GroupScratch::Buffers& b) {
  const FloatTag d;
  constexpr size_t kLeaf = SpatialIndex::kLeafSize;
  NeighborArrays& n = b.neighbors;
  n.Reserve(count);
  float *dx = n.dx.data(), *dy = n.dy.data(), *dz = n.dz.data();
  float *nx = n.nx.data(), *ny = n.ny.data(), *nz = n.nz.data();
  const FloatVec qx = hn::Set(d, query[0]), qy = hn::Set(d, query[1]), qz = hn::Set(d, query[2]);
  FloatVec farthest = hn::Zero(d);
  size_t out = 0;
  for (size_t j = 0; j < near_count; ++j) {
    const SpatialIndex::LeafPositions& points = index.positions(b.near[j]);
    const SpatialIndex::LeafNormals& normals = index.normals(b.near[j]);
    for (size_t i = 0; i < kLeaf; i += hn::Lanes(d)) {
      const FloatVec squared = hn::Load(d, b.squared_distances.data() + j * kLeaf + i);
      const FloatMask inside = Inside<kSplitsTies>(index, b.near[j], i, squared, cutoff);
      const size_t kept = hn::CountTrue(d, inside);
      if (kept == 0) continue;
      farthest = hn::Max(farthest, hn::IfThenElseZero(inside, squared));
      hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.x + i), qx), inside), d, dx + out);
      hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.y + i), qy), inside), d, dy + out);
      hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.z + i), qz), inside), d, dz + out);
      hn::StoreU(hn::Compress(hn::Load(d, normals.x + i), inside), d, nx + out);
      hn::StoreU(hn::Compress(hn::Load(d, normals.y + i), inside), d, ny + out);
      hn::StoreU(hn::Compress(hn::Load(d, normals.z + i), inside), d, nz + out);
      out += kept;
    }
  }
  for (float* array : {dx, dy, dz, nx, ny, nz}) hn::StoreU(hn::Zero(d), d, array + out);
  n.count = out;
  SumNormals(n);
  return hn::GetLane(hn::MaxOfLanes(d, farthest));
}

// Sums the normals of the points inside the cutoff; sets their number. Returns the largest squared distance.
template <bool kSplitsTies>
HWY_INLINE float SumNeighborNormals(const SpatialIndex& index, const Cutoff& cutoff, size_t near_count,
                                    GroupScratch::Buffers& b) {
  const FloatTag d;
  constexpr size_t kLeaf = SpatialIndex::kLeafSize;
  FloatVec x = hn::Zero(d), y = hn::Zero(d), z = hn::Zero(d);
  FloatVec farthest = hn::Zero(d);
  size_t count = 0;
  for (size_t j = 0; j < near_count; ++j) {
    const SpatialIndex::LeafNormals& normals = index.normals(b.near[j]);
    for (size_t i = 0; i < kLeaf; i += hn::Lanes(d)) {
      const FloatVec squared = hn::Load(d, b.squared_distances.data() + j * kLeaf + i);
      const FloatMask inside = Inside<kSplitsTies>(index, b.near[j], i, squared, cutoff);
      count += hn::CountTrue(d, inside);
      farthest = hn::Max(farthest, hn::IfThenElseZero(inside, squared));
      x = AddWhere(inside, x, hn::Load(d, normals.x + i));
      y = AddWhere(inside, y, hn::Load(d, normals.y + i));
      z = AddWhere(inside, z, hn::Load(d, normals.z + i));
    }
  }
  b.neighbors.count = count;
  StoreSums(x, y, z, b.neighbors.normal_sum);
  return hn::GetLane(hn::MaxOfLanes(d, farthest));
}

// What is wanted of a neighborhood, besides its size.
enum class Wanted {
  kNeighbors,  // the neighbors, and the sum of their normals
  kNormalSum,  // the latter alone
};

template <Wanted kWanted, bool kSplitsTies>
HWY_INLINE float CollectOrSum(const SpatialIndex& index, const float* query, const Cutoff& cutoff, size_t count,
                              size_t near_count, GroupScratch::Buffers& b) {
  if constexpr (kWanted == Wanted::kNormalSum) return SumNeighborNormals<kSplitsTies>(index, cutoff, near_count, b);
  return CollectNeighbors<kSplitsTies>(index, query, cutoff, count, near_count, b);
}

template <Wanted kWanted>
HWY_INLINE float Collect(const SpatialIndex& index, const float* query, const Cutoff& cutoff, size_t count,
                         size_t near_count, GroupScratch::Buffers& b) {
  b.near_count = near_count;
  b.last_rank = {cutoff.limit, cutoff.last_id};
  return cutoff.splits_ties() ? CollectOrSum<kWanted, true>(index, query, cutoff, count, near_count, b)
                              : CollectOrSum<kWanted, false>(index, query, cutoff, count, near_count, b);
}

// Collects the K nearest points from the listed leaves, which hold every point within `squared_reach`. Returns the
// largest squared distance, or a negative value if fewer than K points are that near. `squared_guess` only seeds.
template <Wanted kWanted>
HWY_INLINE float NearestInReach(const SpatialIndex& index, const LeafList& leaves, const float* query, size_t k,
                                float squared_guess, float squared_reach, GroupScratch::Buffers& b) {
  float squared_radius = std::min(squared_guess, squared_reach);
  size_t near_count = CullLeaves(leaves, query, squared_radius, b);
  size_t inner = MeasureDistances(index, query, squared_radius, near_count, b);
  if (inner < k && squared_radius < squared_reach) {
    squared_radius = squared_reach;
    near_count = CullLeaves(leaves, query, squared_radius, b);
    inner = MeasureDistances(index, query, squared_radius, near_count, b);
  }
  if (inner < k) return -1.0f;
  const CountedLimit counted = LimitByCounting(b.inner_distances.data(), inner, k, squared_radius);
  const Cutoff cutoff = counted.count == k ? Cutoff{counted.limit} : SplitTies(index, counted, k, near_count, b);
  return Collect<kWanted>(index, query, cutoff, k, near_count, b);
}

// The same by descent of the tree, for any surroundings.
template <Wanted kWanted>
HWY_NOINLINE float NearestByDescent(const SpatialIndex& index, const float* query, size_t k, GroupScratch::Buffers& b) {
  const NeighborRank last = KthNeighbor(index, query, k, b.heap);
  const Box point{{query[0], query[1], query[2]}, {query[0], query[1], query[2]}};
  GatherLeaves(index, point, last.squared_distance, index.leaf_count(), b.own_leaves);
  const size_t near_count = CullLeaves(b.own_leaves, query, last.squared_distance, b);
  MeasureDistances(index, query, last.squared_distance, near_count, b);
  return Collect<kWanted>(index, query, {last.squared_distance, last.id}, k, near_count, b);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_SEARCH_NEIGHBORHOOD_INL_H_
