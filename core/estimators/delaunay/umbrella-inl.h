// Umbrellas of the points of a group: nearest neighbors, projected to each point's tangent plane, to their Delaunay
// star.

#if defined(CURVD_CORE_ESTIMATORS_DELAUNAY_UMBRELLA_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_DELAUNAY_UMBRELLA_INL_H_
#undef CURVD_CORE_ESTIMATORS_DELAUNAY_UMBRELLA_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_DELAUNAY_UMBRELLA_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/estimators/delaunay/delaunay_star-inl.h"
#include "core/estimators/delaunay/umbrella.h"
#include "core/estimators/group_points-inl.h"
#include "core/estimators/group_scratch.h"
#include "core/search/group_search-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// A neighbor whose projection is nearer than this part of its distance lies along the normal: float offsets say nothing
// about its direction in the plane.
inline constexpr double kMinProjection = 1e-6;

// The neighbors that the last search found, in tree order. Room for a vector more than there may be.
struct UmbrellaCandidates {
  static constexpr int kRoom = DelaunayStar::kCapacity + SpatialIndex::kLeafSize;
  alignas(64) float dx[kRoom], dy[kRoom], dz[kRoom];  // from the point; padded with zeros
  int32_t place[kRoom];
  int32_t id[kRoom];
  int count;
};

// A visitor of GroupSearch that collects the neighbors of query[0..2] as candidates.
class CandidateCollector {
 public:
  CandidateCollector(const SpatialIndex& index, const float* query, UmbrellaCandidates& out)
      : index_(&index), query_(query), out_(&out) {}

  HWY_INLINE void Start(size_t) { count_ = 0; }
  HWY_INLINE void operator()(const NearPoints& near, FloatMask inside) {
    const FloatTag d;
    const IntTag di;
    const size_t kept = hn::CountTrue(d, inside);
    if (kept == 0) return;
    const SpatialIndex::LeafPositions& points = index_->positions(near.leaf);
    const QueryVectors q(query_);
    const size_t lane = near.place;
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.x + lane), q.x), inside), d, out_->dx + count_);
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.y + lane), q.y), inside), d, out_->dy + count_);
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.z + lane), q.z), inside), d, out_->dz + count_);
    const auto inside_ids = hn::RebindMask(di, inside);
    const auto first = static_cast<int32_t>(size_t{near.leaf} * SpatialIndex::kLeafSize + lane);
    hn::StoreU(hn::Compress(IntsFrom(first), inside_ids), di, out_->place + count_);
    hn::StoreU(hn::Compress(hn::Load(di, points.id + lane), inside_ids), di, out_->id + count_);
    count_ += static_cast<int>(kept);
  }
  HWY_INLINE void Finish() {
    const FloatTag d;
    for (float* offsets : {out_->dx, out_->dy, out_->dz}) hn::StoreU(hn::Zero(d), d, offsets + count_);
    out_->count = count_;
  }

 private:
  const SpatialIndex* index_;
  const float* query_;
  UmbrellaCandidates* out_;
  int count_ = 0;
};

// Two axes of the tangent plane that with the normal make a right-handed frame.
struct PlaneAxes {
  double u[3], v[3];
};

inline PlaneAxes AxesOf(const float* normal) {
  double n[3] = {normal[0], normal[1], normal[2]};
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  for (double& component : n) component /= length;
  int least = std::abs(n[1]) < std::abs(n[0]) ? 1 : 0;
  if (std::abs(n[2]) < std::abs(n[least])) least = 2;
  // The axis along the least component, less its part along the normal.
  PlaneAxes axes;
  const double part = std::sqrt(1.0 - n[least] * n[least]);
  for (int c = 0; c < 3; ++c) axes.u[c] = ((c == least ? 1.0 : 0.0) - n[least] * n[c]) / part;
  for (int c = 0; c < 3; ++c) {
    const int next = (c + 1) % 3, last = (c + 2) % 3;
    axes.v[c] = n[next] * axes.u[last] - n[last] * axes.u[next];
  }
  return axes;
}

// Projects the neighbors into the plane; those that say nothing about a direction become no candidates. Returns whether
// one with a lower id coincides with the point.
HWY_INLINE bool Project(const UmbrellaCandidates& neighbors, const PlaneAxes& axes, DelaunayStar& star) {
  const DoubleTag d;
  const hn::Rebind<float, DoubleTag> df;
  const DoubleVec ux = hn::Set(d, axes.u[0]), uy = hn::Set(d, axes.u[1]), uz = hn::Set(d, axes.u[2]);
  const DoubleVec vx = hn::Set(d, axes.v[0]), vy = hn::Set(d, axes.v[1]), vz = hn::Set(d, axes.v[2]);
  const DoubleVec steep = hn::Set(d, kMinProjection * kMinProjection);
  const auto sum = [](DoubleVec a, DoubleVec b, DoubleVec c) HWY_ATTR { return hn::Add(hn::Add(a, b), c); };
  uint32_t coincident = 0;
  for (int i = 0; i < star.count; i += static_cast<int>(hn::Lanes(d))) {
    const DoubleVec dx = hn::PromoteTo(d, hn::Load(df, neighbors.dx + i));
    const DoubleVec dy = hn::PromoteTo(d, hn::Load(df, neighbors.dy + i));
    const DoubleVec dz = hn::PromoteTo(d, hn::Load(df, neighbors.dz + i));
    const DoubleVec x = sum(hn::Mul(dx, ux), hn::Mul(dy, uy), hn::Mul(dz, uz));
    const DoubleVec y = sum(hn::Mul(dx, vx), hn::Mul(dy, vy), hn::Mul(dz, vz));
    const DoubleVec squared = hn::Add(hn::Mul(x, x), hn::Mul(y, y));
    const DoubleVec squared_distance = sum(hn::Mul(dx, dx), hn::Mul(dy, dy), hn::Mul(dz, dz));
    const DoubleMask candidate = hn::Gt(squared, hn::Mul(steep, squared_distance));
    hn::Store(hn::IfThenElseZero(candidate, x), d, star.x + i);
    hn::Store(hn::IfThenElseZero(candidate, y), d, star.y + i);
    hn::Store(hn::IfThenElseZero(candidate, hn::Sqrt(squared)), d, star.length + i);
    uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Eq(squared_distance, hn::Zero(d)), bits);
    coincident |= static_cast<uint32_t>(bits[0]) << i;
  }
  coincident &= (uint32_t{1} << star.count) - 1;
  bool lower = false;
  for (; coincident != 0; coincident &= coincident - 1) lower |= star.id[std::countr_zero(coincident)] < star.own_id;
  return lower;
}

// The umbrella of a point with this id and normal. Of points that coincide only the one with the lowest id has one; the
// others' triangles would cover the same surface again. Returns the steps of it: the neighbors, times those of the
// walk.
HWY_NOINLINE inline uint64_t SetUmbrella(const UmbrellaCandidates& neighbors, int32_t own_id, const float* normal,
                                         Umbrella& umbrella) {
  std::fill(std::begin(umbrella.rim), std::end(umbrella.rim), Umbrella::kNone);
  DelaunayStar star;
  star.count = neighbors.count;
  star.id = neighbors.id;
  star.own_id = own_id;
  const auto candidates = static_cast<uint64_t>(neighbors.count);
  if (Project(neighbors, AxesOf(normal), star)) return candidates;
  int rim[Umbrella::kMaxRim];
  const int size = star.Walk(rim);
  for (int corner = 0; corner < size; ++corner) umbrella.rim[corner] = neighbors.place[rim[corner]];
  return candidates * static_cast<uint64_t>(2 + star.steps);
}

// Sets the rims of the umbrellas of all points of a group, also of those that get no result, until the run has become
// long. `umbrellas` holds those of the whole cloud, by place in the tree order.
inline void BuildUmbrellasKernel(const SpatialIndex& index, const SearchPlan& plan, size_t group, GroupScratch& s,
                                 Umbrella* umbrellas) {
  LoadGroup<true>(index, group, s.points, s.first_point);
  const uint64_t began = s.search.work;
  s.search.stopped = s.stopped;
  GroupSearch search(index, plan, s.points.box, s.search);
  UmbrellaCandidates candidates;
  float query[3], normal[3];
  for (size_t i = 0; i < s.points.size; ++i) {
    s.points.query.Get(i, query);
    s.points.normal.Get(i, normal);
    search.Find(query, CandidateCollector(index, query, candidates));
    if (s.IsStopped()) return;
    s.search.work += SetUmbrella(candidates, s.points.rank[i], normal, umbrellas[s.points.place[i]]);
    if (s.IsLongSince(began) && i + 1 < s.points.size) s.LeaveRest(i + 1);
  }
  search.PassOn();
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_DELAUNAY_UMBRELLA_INL_H_
