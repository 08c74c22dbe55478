// Looks for a seam in one neighborhood: normals that point to opposite sides of one sheet.

#if defined(CURVD_CORE_ESTIMATORS_SEAMS_FIND_SEAM_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_SEAMS_FIND_SEAM_INL_H_
#undef CURVD_CORE_ESTIMATORS_SEAMS_FIND_SEAM_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_SEAMS_FIND_SEAM_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/estimators/neighbors/neighbors.h"
#include "core/estimators/seams/one_sheet.h"
#include "core/search/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Where the least agreement of a neighborhood (NormalSums) is above this, none of its normals may be opposed to the
// query's: kMayOppose with room for vectors that round differently.
inline constexpr float kNoneOpposed = -kMayOppose + 1e-4f;

// The smallest of the values that were added, in ascending order.
template <size_t kMost>
class SmallestValues {
 public:
  void Add(float value) {
    if (!(value < bound())) return;
    size_t i = size_ < kMost ? size_++ : kMost - 1;
    for (; i > 0 && value < values_[i - 1]; --i) values_[i] = values_[i - 1];
    values_[i] = value;
  }
  size_t size() const { return size_; }
  // Only values below are kept.
  float bound() const { return size_ < kMost ? std::numeric_limits<float>::infinity() : values_[kMost - 1]; }
  // REQUIRES: size() > 0.
  float largest() const { return values_[size_ - 1]; }

 private:
  size_t size_ = 0;
  float values_[kMost] = {};
};

// A neighbor beside its query.
struct ComparedNeighbor {
  size_t place;  // in the tree order
  float squared_distance;
  float agreement;   // the cosine between the normals
  double along;      // its offset along the query's normal
  double along_own;  // and along its own

  double Distance() const { return std::sqrt(double{squared_distance}); }
  bool Agrees() const { return agreement > kAlong; }
  bool IsOpposed() const { return agreement < -kAlong; }
  bool MayBeOpposed() const { return agreement < -kMayOppose; }
  // Heights over the query's sheet (SheetHeights). REQUIRES: it agrees; it may be opposed.
  double AgreeingHeight() const { return (along + along_own) / 2; }
  double OpposedHeight() const { return (along - along_own) / 2; }
};

// The normal of a query in all lanes, and its products with a vector of others: rounded as in scalar code.
class NormalProducts {
 public:
  explicit HWY_INLINE NormalProducts(const QueryPoint& query) : own_(query.normal) {}
  HWY_INLINE FloatVec operator()(const SpatialIndex::LeafNormals& normals, size_t i) const {
    const FloatTag d;
    const FloatVec x = hn::Mul(hn::Load(d, normals.x + i), own_.x), y = hn::Mul(hn::Load(d, normals.y + i), own_.y);
    return hn::Add(hn::Add(x, y), hn::Mul(hn::Load(d, normals.z + i), own_.z));
  }

 private:
  const QueryVectors own_;
};

// Calls visit(neighbor) for those neighbors that the last search found, the query among them, for which
// select(agreement, squared_distance) is true. The operations are the same on every instruction set.
template <typename Select, typename Visit>
HWY_INLINE void ForEachSelected(const SpatialIndex& index, const Neighborhood& found, const QueryPoint& query,
                                Select select, Visit visit) {
  const NormalProducts products(query);
  const auto compare = [&](const NearPoints& near, FloatMask inside) CURVD_INLINED {
    const SpatialIndex::LeafPositions& points = index.positions(near.leaf);
    const SpatialIndex::LeafNormals& normals = index.normals(near.leaf);
    const FloatMask selected = hn::And(inside, select(products(normals, near.place), near.squared));
    for (uint64_t bits = BitsFromMask(selected); bits != 0; bits &= bits - 1) {
      const size_t i = near.place + static_cast<size_t>(std::countr_zero(bits));
      const float d[3] = {points.x[i] - query.position[0], points.y[i] - query.position[1],
                          points.z[i] - query.position[2]};
      const float n[3] = {normals.x[i], normals.y[i], normals.z[i]};
      const float* const own = query.normal;
      visit(ComparedNeighbor{near.leaf * size_t{SpatialIndex::kLeafSize} + i,
                             found.squared_distances[near.near * SpatialIndex::kLeafSize + i],
                             (n[0] * own[0] + n[1] * own[1]) + n[2] * own[2],
                             (double{d[0]} * own[0] + double{d[1]} * own[1]) + double{d[2]} * own[2],
                             (double{d[0]} * n[0] + double{d[1]} * n[1]) + double{d[2]} * n[2]});
    }
  };
  ForEachInside(index, found, compare);
}

// The same for all neighbors.
template <typename Visit>
HWY_INLINE void ForEachCompared(const SpatialIndex& index, const Neighborhood& found, const QueryPoint& query,
                                Visit visit) {
  const auto all = [](FloatVec, FloatVec squared) CURVD_INLINED { return hn::Eq(squared, squared); };
  ForEachSelected(index, found, query, all, visit);
}

// The mean height of the neighbors up to a distance whose normals agree, in floats, and by how much it may be off.
struct RoughHeight {
  double mean, tolerance;
};

HWY_INLINE RoughHeight RoughAgreeingHeight(const SpatialIndex& index, const Neighborhood& found,
                                           const QueryPoint& query, float squared_reach) {
  const FloatTag d;
  const NormalProducts products(query);
  const QueryVectors position(query.position), own(query.normal);
  const FloatVec along = hn::Set(d, kAlong), limit = hn::Set(d, squared_reach);
  FloatVec sum = hn::Zero(d);
  size_t count = 0;
  const auto add = [&](const NearPoints& near, FloatMask inside) CURVD_INLINED {
    const SpatialIndex::LeafPositions& points = index.positions(near.leaf);
    const SpatialIndex::LeafNormals& normals = index.normals(near.leaf);
    const auto on_axis = [&near, d](const float* of_point, const float* of_normal, FloatVec from, FloatVec own_normal)
                             CURVD_INLINED {
                               const FloatVec offset = hn::Sub(hn::Load(d, of_point + near.place), from);
                               return hn::Mul(offset, hn::Add(hn::Load(d, of_normal + near.place), own_normal));
                             };
    const FloatVec twice_height = hn::Add(
        hn::Add(on_axis(points.x, normals.x, position.x, own.x), on_axis(points.y, normals.y, position.y, own.y)),
        on_axis(points.z, normals.z, position.z, own.z));
    const FloatMask agrees =
        hn::And(hn::And(inside, hn::Le(near.squared, limit)), hn::Gt(products(normals, near.place), along));
    sum = AddWhere(agrees, sum, twice_height);
    count += hn::CountTrue(d, agrees);
  };
  ForEachInside(index, found, add);
  if (count == 0) return {0.0, 0.0};
  // No height is larger than the distance. Sums of n floats err by less than n times 6e-8 of their addends' sizes.
  const double n = static_cast<double>(count), reach = std::sqrt(double{squared_reach});
  return {double{hn::GetLane(hn::SumOfLanes(d, sum))} / 2.0 / n, (1e-6 + 1e-7 * n) * reach};
}

struct SeamFinding {
  bool may_be_beside_seam = false;
  bool is_beside_seam = false;  // without doubt
};

// Judges the neighborhood that the last search found for `query` by the nearest of its points whose normals are opposed
// to the query's. At most four passes over the neighbors, and no memory.
HWY_NOINLINE inline SeamFinding FindSeam(const SpatialIndex& index, const Neighborhood& found,
                                         const QueryPoint& query) {
  constexpr size_t kJudged = 8;
  constexpr size_t kAlongOf = 4, kOf = 5;  // this share of the neighbors must agree or be opposed
  const FloatTag d;
  const FloatVec least_doubted = hn::Set(d, -kMayOppose);
  SmallestValues<kJudged> opposed_distances, doubted_distances;
  const auto may_count = [&](FloatVec agreement, FloatVec squared) CURVD_INLINED {
    return hn::And(hn::Lt(agreement, least_doubted), hn::Lt(squared, hn::Set(d, opposed_distances.bound())));
  };
  ForEachSelected(index, found, query, may_count, [&](const ComparedNeighbor& neighbor) {
    if (neighbor.IsOpposed()) opposed_distances.Add(neighbor.squared_distance);
    doubted_distances.Add(neighbor.squared_distance);
  });
  if (doubted_distances.size() == 0) return {};
  const float reach = opposed_distances.size() == 0 ? -1.0f : opposed_distances.largest();
  const float doubted_reach = doubted_distances.largest();
  const auto up_to = [d](float squared_reach) {
    return [limit = hn::Set(d, squared_reach)](FloatVec squared) CURVD_INLINED { return hn::Le(squared, limit); };
  };

  SheetHeights agreeing, opposed;
  double distance_sum = 0.0;
  bool has_one_on_sheet = false;
  const auto is_near = up_to(std::max(reach, doubted_reach)), is_judged = up_to(reach);
  const auto is_doubted_near = [&](FloatVec agreement, FloatVec squared) CURVD_INLINED {
    return hn::And(hn::Lt(agreement, least_doubted), is_near(squared));
  };
  ForEachSelected(index, found, query, is_doubted_near, [&](const ComparedNeighbor& neighbor) {
    if (neighbor.squared_distance <= doubted_reach) {
      has_one_on_sheet = has_one_on_sheet || MayLieOnOneSheet(neighbor.OpposedHeight(), neighbor.Distance());
    }
    if (neighbor.squared_distance > reach || !neighbor.IsOpposed()) return;
    opposed.Add(neighbor.OpposedHeight());
    distance_sum += neighbor.Distance();
  });
  if (opposed.count() == 0) return {.may_be_beside_seam = has_one_on_sheet};
  const double distance = distance_sum / static_cast<double>(opposed.count());

  // Beside a thin part floats will do to tell that the others lie on another sheet.
  if (!has_one_on_sheet) {
    const RoughHeight rough = RoughAgreeingHeight(index, found, query, reach);
    const double nearest = std::max(std::abs(opposed.Mean() - rough.mean) - rough.tolerance, 0.0);
    if (!MayLieOnOneSheet(nearest, distance)) return {};
  }
  size_t judged = 0;
  const auto to_reach = [&](FloatVec, FloatVec squared) CURVD_INLINED { return is_judged(squared); };
  ForEachSelected(index, found, query, to_reach, [&](const ComparedNeighbor& neighbor) {
    ++judged;
    if (neighbor.Agrees()) agreeing.Add(neighbor.AgreeingHeight());
  });
  // One neighbor alone raises doubt where the others lie on another sheet, and hide it in their mean.
  if (!has_one_on_sheet && !MayLieOnOneSheet(agreeing, opposed, distance)) return {};
  // A point whose own normal errs by half a right angle is no judge: few normals lie along it, to either side.
  const bool is_judge = kOf * (agreeing.count() + opposed.count()) >= kAlongOf * judged;
  return {true, is_judge && LieOnOneSheet(agreeing, opposed, distance)};
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_SEAMS_FIND_SEAM_INL_H_
