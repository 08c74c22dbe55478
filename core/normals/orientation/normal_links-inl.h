// Compares the normals of the points of one group with those of their neighbors.

#if defined(CURVD_CORE_NORMALS_ORIENTATION_NORMAL_LINKS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_NORMALS_ORIENTATION_NORMAL_LINKS_INL_H_
#undef CURVD_CORE_NORMALS_ORIENTATION_NORMAL_LINKS_INL_H_
#else
#define CURVD_CORE_NORMALS_ORIENTATION_NORMAL_LINKS_INL_H_
#endif

#include <algorithm>
#include <cmath>

#include "core/estimators/group_estimate-inl.h"
#include "core/normals/orientation/normal_links.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// The neighbors of one point, itself included, with room for a vector more.
struct alignas(64) LinkNeighbors {
  static constexpr size_t kRoom = kMostLinksPerPoint + size_t{2} * SpatialIndex::kLeafSize;

  float dx[kRoom], dy[kRoom], dz[kRoom];  // offsets
  float nx[kRoom], ny[kRoom], nz[kRoom];  // normals
  float squared[kRoom];                   // distances
  int32_t place[kRoom];
  float cost[kRoom];
  float agreement[kRoom];  // negative: opposite
  size_t count = 0;
};

class LinkCollector {
 public:
  LinkCollector(const SpatialIndex& index, const QueryPoint& query, LinkNeighbors& out)
      : index_(&index), query_(&query), out_(&out) {}

  HWY_INLINE void Start(size_t) { count_ = 0; }
  HWY_INLINE void operator()(const NearPoints& near, FloatMask inside) {
    const FloatTag d;
    const IntTag di;
    const size_t kept = hn::CountTrue(d, inside);
    if (kept == 0) return;
    const SpatialIndex::LeafPositions& points = index_->positions(near.leaf);
    const SpatialIndex::LeafNormals& normals = index_->normals(near.leaf);
    const QueryVectors q(query_->position);
    const size_t i = near.place;
    const auto first = static_cast<int32_t>(size_t{near.leaf} * SpatialIndex::kLeafSize + i);
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.x + i), q.x), inside), d, out_->dx + count_);
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.y + i), q.y), inside), d, out_->dy + count_);
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.z + i), q.z), inside), d, out_->dz + count_);
    hn::StoreU(hn::Compress(hn::Load(d, normals.x + i), inside), d, out_->nx + count_);
    hn::StoreU(hn::Compress(hn::Load(d, normals.y + i), inside), d, out_->ny + count_);
    hn::StoreU(hn::Compress(hn::Load(d, normals.z + i), inside), d, out_->nz + count_);
    hn::StoreU(hn::Compress(near.squared, inside), d, out_->squared + count_);
    hn::StoreU(hn::Compress(hn::Iota(di, first), hn::RebindMask(di, inside)), di, out_->place + count_);
    count_ += kept;
  }
  HWY_INLINE void Finish() { out_->count = count_; }

 private:
  const SpatialIndex* index_;
  const QueryPoint* query_;
  LinkNeighbors* out_;
  size_t count_ = 0;
};

// Sets cost and agreement of each neighbor of a point with normal (nx, ny, nz). No fused operations: the sums of
// products are the same from both points.
HWY_INLINE void CompareNormals(float nx, float ny, float nz, LinkNeighbors& n) {
  const FloatTag d;
  const FloatVec zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  const FloatVec ax = hn::Set(d, nx), ay = hn::Set(d, ny), az = hn::Set(d, nz);
  const auto dot = [](FloatVec x1, FloatVec y1, FloatVec z1, FloatVec x2, FloatVec y2, FloatVec z2)
                       HWY_ATTR { return hn::Add(hn::Add(hn::Mul(x1, x2), hn::Mul(y1, y2)), hn::Mul(z1, z2)); };
  for (size_t j = 0; j < n.count; j += hn::Lanes(d)) {
    const FloatVec squared = hn::Load(d, n.squared + j);
    // Coincident points have no way between them.
    const FloatVec per_length = hn::IfThenElseZero(hn::Gt(squared, zero), hn::Div(one, hn::Sqrt(squared)));
    const FloatVec x = hn::Mul(hn::Load(d, n.dx + j), per_length), y = hn::Mul(hn::Load(d, n.dy + j), per_length);
    const FloatVec z = hn::Mul(hn::Load(d, n.dz + j), per_length);
    const FloatVec bx = hn::Load(d, n.nx + j), by = hn::Load(d, n.ny + j), bz = hn::Load(d, n.nz + j);
    const FloatVec across_a = dot(x, y, z, ax, ay, az), across_b = dot(x, y, z, bx, by, bz);
    const FloatVec both = hn::Mul(across_a, across_b);
    const FloatVec agreement = hn::Sub(dot(ax, ay, az, bx, by, bz), hn::Add(both, both));
    const FloatVec across = hn::Add(hn::Abs(across_a), hn::Abs(across_b));
    hn::Store(agreement, d, n.agreement + j);
    // Rounding may bring the agreement above 1.
    hn::Store(hn::Add(hn::Max(hn::Sub(one, hn::Abs(agreement)), zero), across), d, n.cost + j);
  }
}

HWY_INLINE void AppendLinksOf(uint32_t place, const LinkNeighbors& n, LinkScratch& s) {
  s.links.Reserve(s.link_count + n.count);
  NormalLink* next = s.links.data() + s.link_count;
  const float* const reaches = s.reaches.data();
  const auto first = static_cast<uint32_t>(s.first_reach);
  for (size_t j = 0; j < n.count; ++j) {
    const auto other = static_cast<uint32_t>(n.place[j]);
    *next = {n.cost[j], place, other, n.agreement[j] < 0.0f ? 1u : 0u};
    // Neighbors without a normal have NaN. The point is a neighbor of those that reach beyond it, since distances are
    // the same from both ends.
    const bool is_linked = other - first < place - first && n.squared[j] < reaches[other - first];
    next += other == place || n.nx[j] != n.nx[j] || is_linked ? 0 : 1;
  }
  s.link_count = static_cast<size_t>(next - s.links.data());
}

// Returns the squared distance that has n.count / 2 others before it in ascending order.
HWY_INLINE float MiddleDistance(const LinkNeighbors& n) {
  const FloatTag d;
  const size_t before = n.count / 2;
  const FloatVec zero = hn::Zero(d), one = hn::Set(d, 1.0f), middle = hn::Set(d, static_cast<float>(before));
  for (size_t i = 0; i < n.count; i += hn::Lanes(d)) {
    const FloatVec own = hn::Load(d, n.squared + i);
    FloatVec less = zero, at_most = zero;
    for (size_t j = 0; j < n.count; ++j) {
      const FloatVec other = hn::Set(d, n.squared[j]);
      less = hn::Add(less, hn::IfThenElseZero(hn::Lt(other, own), one));
      at_most = hn::Add(at_most, hn::IfThenElseZero(hn::Le(other, own), one));
    }
    const auto is_it = hn::And(hn::And(hn::Le(less, middle), hn::Lt(middle, at_most)), hn::FirstN(d, n.count - i));
    const intptr_t lane = hn::FindFirstTrue(d, is_it);
    if (lane >= 0) return n.squared[i + static_cast<size_t>(lane)];
  }
  return 0.0f;
}

inline absl::Status AppendLinksKernel(const SpatialIndex& index, const NeighborhoodPlan& plan, size_t group,
                                      LinkScratch& s, PackedArea* areas) {
  LoadGroup<true>(index, group, s.points, s.first_point);
  LinkNeighbors neighbors;
  QueryPoint query;
  // kPointsPerArea is that of kLinksPerPoint neighbors.
  const size_t count = std::max(plan.search.searched_count, kLinksPerPoint + 1);
  const float area_factor = static_cast<float>(kLinksPerPoint + 1) / static_cast<float>(count);
  const auto compare = [&](size_t i, const LeafList&) HWY_ATTR {
    const auto place = static_cast<uint32_t>(s.points.place[i]);
    areas[place] = 0;
    s.reaches[place - s.first_reach] = 0.0f;
    if (std::isnan(s.points.normal.x[i])) return;
    CompareNormals(s.points.normal.x[i], s.points.normal.y[i], s.points.normal.z[i], neighbors);
    AppendLinksOf(place, neighbors, s);
    s.reaches[place - s.first_reach] = s.neighborhoods.squared_radius[i];
    areas[place] = PackArea(area_factor * MiddleDistance(neighbors));
  };
  return ForEachNeighborhood(index, plan, query, kNoNormals, LinkCollector(index, query, neighbors), s, compare);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_NORMALS_ORIENTATION_NORMAL_LINKS_INL_H_
