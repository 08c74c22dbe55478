// Looks for a seam in one neighborhood: normals that point to opposite sides of one sheet.

#if defined(CURVD_CORE_ESTIMATORS_SEAMS_FIND_SEAM_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_SEAMS_FIND_SEAM_INL_H_
#undef CURVD_CORE_ESTIMATORS_SEAMS_FIND_SEAM_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_SEAMS_FIND_SEAM_INL_H_
#endif

#include <bit>
#include <cmath>

#include "core/estimators/neighbors.h"
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
    if (size_ == kMost && !(value < values_[kMost - 1])) return;
    size_t i = size_ < kMost ? size_++ : kMost - 1;
    for (; i > 0 && value < values_[i - 1]; --i) values_[i] = values_[i - 1];
    values_[i] = value;
  }
  size_t size() const { return size_; }
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

// Calls visit(neighbor) for each neighbor that the last search found, the query among them. The operations are the same
// on every instruction set.
template <typename Visit>
HWY_INLINE void ForEachCompared(const SpatialIndex& index, const Neighborhood& found, const QueryPoint& query,
                                Visit visit) {
  const auto compare = [&](const NearPoints& near, FloatMask inside) CURVD_INLINED {
    const SpatialIndex::LeafPositions& points = index.positions(near.leaf);
    const SpatialIndex::LeafNormals& normals = index.normals(near.leaf);
    for (uint64_t bits = BitsFromMask(inside); bits != 0; bits &= bits - 1) {
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

struct SeamFinding {
  bool may_be_beside_seam = false;
  bool is_beside_seam = false;  // without doubt
};

// Judges the neighborhood that the last search found for `query` by the nearest of its points whose normals are opposed
// to the query's. Two passes over the neighbors, and no memory.
HWY_NOINLINE inline SeamFinding FindSeam(const SpatialIndex& index, const Neighborhood& found,
                                         const QueryPoint& query) {
  constexpr size_t kJudged = 8;
  constexpr size_t kAlongOf = 4, kOf = 5;  // this share of the neighbors must agree or be opposed
  SmallestValues<kJudged> opposed_distances, doubted_distances;
  ForEachCompared(index, found, query, [&](const ComparedNeighbor& neighbor) {
    if (neighbor.IsOpposed()) opposed_distances.Add(neighbor.squared_distance);
    if (neighbor.MayBeOpposed()) doubted_distances.Add(neighbor.squared_distance);
  });
  if (doubted_distances.size() == 0) return {};
  const float reach = opposed_distances.size() == 0 ? -1.0f : opposed_distances.largest();
  const float doubted_reach = doubted_distances.largest();
  SheetHeights agreeing, opposed;
  double distance_sum = 0.0;
  size_t judged = 0;
  bool has_one_on_sheet = false;
  ForEachCompared(index, found, query, [&](const ComparedNeighbor& neighbor) {
    if (neighbor.MayBeOpposed() && neighbor.squared_distance <= doubted_reach) {
      has_one_on_sheet = has_one_on_sheet || MayLieOnOneSheet(neighbor.OpposedHeight(), neighbor.Distance());
    }
    if (neighbor.squared_distance > reach) return;
    ++judged;
    if (neighbor.Agrees()) agreeing.Add(neighbor.AgreeingHeight());
    if (!neighbor.IsOpposed()) return;
    opposed.Add(neighbor.OpposedHeight());
    distance_sum += neighbor.Distance();
  });
  if (opposed.count() == 0) return {.may_be_beside_seam = has_one_on_sheet};
  const double distance = distance_sum / static_cast<double>(opposed.count());
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
