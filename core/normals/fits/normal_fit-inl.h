// Fits the points of one group.

#if defined(CURVD_CORE_NORMALS_FITS_NORMAL_FIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_NORMALS_FITS_NORMAL_FIT_INL_H_
#undef CURVD_CORE_NORMALS_FITS_NORMAL_FIT_INL_H_
#else
#define CURVD_CORE_NORMALS_FITS_NORMAL_FIT_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/halves.h"
#include "core/estimators/fits/jet-inl.h"
#include "core/estimators/fits/least_axis.h"
#include "core/estimators/fits/quadric_sums-inl.h"
#include "core/estimators/fits/repeated_search-inl.h"
#include "core/estimators/group_estimate-inl.h"
#include "core/normals/fits/lane_fits-inl.h"
#include "core/normals/fits/normal_plan.h"
#include "core/normals/fits/normal_scratch.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Which points are in a half of the cloud (HalfOf), by their indices.
HWY_INLINE FloatMask AreInHalf(const int32_t* ids, Half half) {
  const hn::RebindToUnsigned<IntTag> d;
  auto hash = hn::BitCast(d, hn::Load(IntTag(), ids));
  hash = hn::Mul(hn::Xor(hash, hn::ShiftRight<kHalfShifts[0]>(hash)), hn::Set(d, kHalfMultipliers[0]));
  hash = hn::Mul(hn::Xor(hash, hn::ShiftRight<kHalfShifts[1]>(hash)), hn::Set(d, kHalfMultipliers[1]));
  const auto bit = hn::And(hn::Xor(hash, hn::ShiftRight<kHalfShifts[2]>(hash)), hn::Set(d, 1u));
  return hn::RebindMask(FloatTag(), hn::Eq(bit, hn::Set(d, static_cast<uint32_t>(half))));
}

// Collects the offsets of the neighbors of a query, or of those in a half of the cloud. Normals are not read: other
// threads may write them.
class OffsetCollector {
 public:
  OffsetCollector(const SpatialIndex& index, const QueryPoint& query, std::optional<Half> half,
                  NeighborArrays& neighbors)
      : index_(&index), query_(&query), half_(half), neighbors_(&neighbors) {}

  HWY_INLINE void Start(size_t count) {
    neighbors_->Reserve(count);
    dx_ = neighbors_->dx.data(), dy_ = neighbors_->dy.data(), dz_ = neighbors_->dz.data();
    count_ = 0;
  }
  HWY_INLINE void operator()(const NearPoints& near, FloatMask inside) {
    const FloatTag d;
    const SpatialIndex::LeafPositions& points = index_->positions(near.leaf);
    if (half_.has_value()) inside = hn::And(inside, AreInHalf(points.id + near.place, *half_));
    const size_t kept = hn::CountTrue(d, inside);
    if (kept == 0) return;
    const QueryVectors q(query_->position);
    const size_t i = near.place;
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.x + i), q.x), inside), d, dx_ + count_);
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.y + i), q.y), inside), d, dy_ + count_);
    hn::StoreU(hn::Compress(hn::Sub(hn::Load(d, points.z + i), q.z), inside), d, dz_ + count_);
    count_ += kept;
  }
  HWY_INLINE void Finish() {
    for (float* array : {dx_, dy_, dz_}) hn::StoreU(hn::Zero(FloatTag()), FloatTag(), array + count_);
    neighbors_->count = count_;
  }

 private:
  const SpatialIndex* index_;
  const QueryPoint* query_;
  std::optional<Half> half_;
  NeighborArrays* neighbors_;
  float *dx_ = nullptr, *dy_ = nullptr, *dz_ = nullptr;
  size_t count_ = 0;
};

// x' m y for m = xx xy xz yy yz zz.
inline double SymmetricProduct(const double* x, const double* m, const double* y) {
  return x[0] * (m[0] * y[0] + m[1] * y[1] + m[2] * y[2]) + x[1] * (m[1] * y[0] + m[3] * y[1] + m[4] * y[2]) +
         x[2] * (m[2] * y[0] + m[4] * y[1] + m[5] * y[2]);
}

inline void GetVector(const GroupDoubleVectors& from, size_t i, double* to) {
  to[0] = from.x[i], to[1] = from.y[i], to[2] = from.z[i];
}

// Whether the neighbors lie together, away from the point, which is one of `count`.
inline bool IsSecluded(const NeighborSpread& spread, size_t count) {
  const double others = static_cast<double>(count) / static_cast<double>(count - 1);
  double squared_mean = 0.0;
  for (const double component : spread.mean) squared_mean += component * others * component * others;
  const double squares = (spread.squares[0] + spread.squares[3] + spread.squares[5]) * others;
  return squared_mean > kMaxSeclusion * (squares - squared_mean);
}

// Sets the frame of point i, and what the spread of its neighbors says about the plane in which they lie best.
inline PointStatus SetPlane(const NeighborSpread& spread, size_t count, size_t i, NormalScratch& s) {
  SetJetFrame(spread, i, s.system);
  double u[3], v[3], axis[3];
  GetVector(s.system.u, i, u);
  GetVector(s.system.v, i, v);
  GetVector(s.system.axis, i, axis);
  const double uu = SymmetricProduct(u, spread.covariance, u), uv = SymmetricProduct(u, spread.covariance, v);
  const double vv = SymmetricProduct(v, spread.covariance, v);
  const double half = 0.5 * (uu - vv), root = std::sqrt(half * half + uv * uv);
  const double widest = 0.5 * (uu + vv) + root, middle = 0.5 * (uu + vv) - root;
  const double least = std::max(SymmetricProduct(axis, spread.covariance, axis), 0.0);
  s.normal.Set(i, axis);
  s.mean_square[i] = least;
  s.mean_square_height[i] = SymmetricProduct(axis, spread.squares, axis);
  s.variance_ratio[i] = std::min(least / middle, 1.0);
  s.breadth[i] = middle / widest;
  if (IsSecluded(spread, count)) return PointStatus::kTooFewNeighbors;
  return middle > kMinLineSpread * widest ? PointStatus::kOk : PointStatus::kSingularFit;
}

// A point whose neighbors' mean is farther away than this share of their radius lies at a rim. At that of a half plane
// it is 0.42; where neighbors are around the point, chance makes it 0.1 to 0.2.
inline constexpr double kRimOffset = 0.25;
// Sheets have heights of so many standard deviations of all heights: 1, but for points of the rim between them.
inline constexpr double kSheetHeight = 0.85;

// Sets the normal of point i if it lies at the rim of two sheets: from one to the other, it turns through the direction
// away from the neighbors, as far as the point's height between the sheets tells.
inline bool SetRim(const NeighborSpread& spread, size_t i, NormalScratch& s) {
  // About the point, not the mean: at a rim, neighbors may spread less across it than from sheet to sheet.
  double axis[3], along[3];
  LeastAxis(spread.squares, axis);
  const double height = -(spread.mean[0] * axis[0] + spread.mean[1] * axis[1] + spread.mean[2] * axis[2]);
  double squared = 0.0;
  for (int c = 0; c < 3; ++c) {
    along[c] = -(spread.mean[c] + height * axis[c]);
    squared += along[c] * along[c];
  }
  if (!(squared > kRimOffset * kRimOffset)) return false;
  const double sheet = kSheetHeight * std::sqrt(std::max(SymmetricProduct(axis, spread.covariance, axis), 0.0));
  const double up = sheet > 0.0 ? std::clamp(height / sheet, -1.0, 1.0) : 1.0;
  const double out = std::sqrt((1.0 - up * up) / squared);
  const double normal[3] = {up * axis[0] + out * along[0], up * axis[1] + out * along[1],
                            up * axis[2] + out * along[2]};
  s.normal.Set(i, normal);
  return true;
}

// Takes the normals and residuals of the points whose jets are solved.
inline void TakeJets(int degree, NormalScratch& s) {
  const JetSystems& jets = s.system;
  for (size_t i = 0; i < s.points.size; ++i) {
    if (s.points.status[i] != PointStatus::kOk) continue;
    const double a = jets.coefficients[JetIndex(1, 0)][i], b = jets.coefficients[JetIndex(0, 1)][i];
    const double per_length = 1.0 / std::sqrt(1.0 + a * a + b * b);
    const double normal[3] = {(jets.axis.x[i] - a * jets.u.x[i] - b * jets.v.x[i]) * per_length,
                              (jets.axis.y[i] - a * jets.u.y[i] - b * jets.v.y[i]) * per_length,
                              (jets.axis.z[i] - a * jets.u.z[i] - b * jets.v.z[i]) * per_length};
    if (!s.is_rim[i]) s.normal.Set(i, normal);
    // At the solution, the heights' squares less what the polynomial explains.
    double explained = 0.0;
    for (int c = 0; c < JetSize(degree); ++c) explained += jets.coefficients[c][i] * jets.heights[c][i];
    s.mean_square[i] = std::max(s.mean_square_height[i] - explained / jets.moments[0][i], 0.0);
  }
}

// The number of neighbors that points of the plan have where several are fitted at once; 0 where each is by itself.
inline size_t CountInLanes(const NormalPlan& plan, const NormalScratch& s) {
  const SearchPlan& search = plan.neighborhood.search;
  const bool in_lanes = !search.by_radius && search.searched_count <= LaneNeighbors::kMostNeighbors;
  return in_lanes && search.searched_count > 1 && !plan.two_sheets && !plan.half.has_value() && !s.inspect
             ? search.searched_count
             : 0;
}

// Fits each of s.points, which are loaded. With `lowers_degree`, points whose neighbors determine no polynomial of the
// plan's degree get one of a lower degree.
HWY_NOINLINE inline absl::Status FitPoints(const SpatialIndex& index, const NormalPlan& plan, bool lowers_degree,
                                           NormalScratch& s) {
  const auto fill = [](size_t) {};
  const auto size = static_cast<size_t>(JetSize(plan.degree));
  // Fewer neighbors than these span no plane, or are no more than the coefficients with a third more: a half of a
  // neighborhood may be so few.
  constexpr size_t kLeastSpread = 3;
  const size_t least = plan.half.has_value() ? std::max(kLeastSpread, size + size / 3) : 0;
  const size_t count = CountInLanes(plan, s), lanes = hn::Lanes(DoubleTag());
  const auto fit = [&](size_t i, const LeafList&) {
    PointStatus& status = s.points.status[i];
    PreparePoints<false>(OnePoint(), plan.neighborhood, s.neighborhoods, i, s.points, s.frames, fill);
    if (count > 0) {
      if (status == PointStatus::kOk) TakeLane(s.neighbors, i, s.lanes);
      if (i % lanes == lanes - 1) FitLanes(plan.degree, count, i - i % lanes, s);
      return;
    }
    if (status != PointStatus::kOk) return;
    if (s.neighbors.count < least) {
      status = PointStatus::kTooFewNeighbors;
      return;
    }
    const double unit = 1.0 / s.frames.rho[i];
    const NeighborSpread spread = MeasureSpread(s.neighbors, unit);
    status = SetPlane(spread, s.neighbors.count, i, s);
    s.is_rim[i] = plan.two_sheets && status == PointStatus::kOk && SetRim(spread, i, s);
    if (status == PointStatus::kOk && s.inspect) s.inspect(i);
    if (status != PointStatus::kOk || plan.degree == 0) return;
    if (s.neighbors.count < size) {
      status = PointStatus::kSingularFit;
      return;
    }
    if (plan.degree == 2) return SumQuadricInFrame(s.neighbors, unit, i, s.system);
    SumJetInFrame(s.neighbors, unit, plan.degree, i, s.columns, s.system);
  };
  QueryPoint query;
  const OffsetCollector collector(index, query, plan.half, s.neighbors);
  const absl::Status status = ForEachNeighborhood(index, plan.neighborhood, query, kNoNormals, collector, s, fit);
  if (!status.ok()) return status;
  if (count > 0 && s.points.size % lanes != 0) {
    for (size_t i = s.points.size; i % lanes != 0; ++i) s.frames.Fill(i);
    FitLanes(plan.degree, count, s.points.size - s.points.size % lanes, s);
  }
  if (plan.degree == 0) return status;
  const auto collect = [&](GroupSearch& search, size_t i) HWY_ATTR {
    s.points.query.Get(i, query.position);
    search.Find(query.position, collector);
  };
  for (size_t i = 0; i < s.points.size && plan.crosses_lines; ++i) {
    s.system.squared_heights[i] = s.mean_square_height[i] * s.system.moments[0][i];
  }
  SolveJetSystems</*kNeedsCurvature=*/false>(plan.degree, s.frames.rho, s.neighbors, s.qr_room, s.points, s.system,
                                             RepeatedSearch(index, plan.neighborhood.search, plan.degree, s, collect),
                                             lowers_degree, lowers_degree && plan.crosses_lines);
  if (s.IsStopped()) return Stopped();
  TakeJets(plan.degree, s);
  return status;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_NORMALS_FITS_NORMAL_FIT_INL_H_
