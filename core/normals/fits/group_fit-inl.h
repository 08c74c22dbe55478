// Fits the points of one group: each for itself, or those of a leaf together.

#if defined(CURVD_CORE_NORMALS_FITS_GROUP_FIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_NORMALS_FITS_GROUP_FIT_INL_H_
#undef CURVD_CORE_NORMALS_FITS_GROUP_FIT_INL_H_
#else
#define CURVD_CORE_NORMALS_FITS_GROUP_FIT_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/normals/fits/fit_group.h"
#include "core/normals/fits/normal_fit-inl.h"
#include "core/normals/fits/normal_plan.h"
#include "core/normals/fits/normal_scratch.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// A point that is farther from the mean of its leaf than this share of the radius, squared, has a fit of its own: noise
// makes the slope of a polynomial err the more, the farther from the middle of its neighborhood it is read. By degree
// 2, over an even disc, the squared error here is 2.5 times that in the middle (docs/numerics/normals.md).
inline constexpr double kMostSquaredOffset = 0.125;

// The mean of the points of a leaf, whichever of them a run fits.
inline void MeanOfLeaf(const SpatialIndex& index, size_t leaf, float* mean) {
  const SpatialIndex::LeafPositions& points = index.positions(leaf);
  const int count = index.LeafPoints(leaf);
  double sums[3] = {0.0, 0.0, 0.0};
  for (int i = 0; i < count; ++i) {
    sums[0] += points.x[i];
    sums[1] += points.y[i];
    sums[2] += points.z[i];
  }
  for (int axis = 0; axis < 3; ++axis) mean[axis] = static_cast<float>(sums[axis] / count);
}

// Sets `means` to the means of the leaves that have members, and to which of them each member belongs. What is not
// position, such as the rank, is that of a leaf's first member.
inline void SetMeans(const SpatialIndex& index, SharedFits& shared, GroupPoints& means) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  means.size = 0;
  means.box = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  int32_t last_leaf = -1;
  for (size_t m = 0; m < shared.members.size; ++m) {
    const int32_t leaf = shared.members.place[m] / SpatialIndex::kLeafSize;
    if (leaf != last_leaf) {
      CopyPoint(shared.members, m, means.size, means);
      float mean[3];
      MeanOfLeaf(index, static_cast<size_t>(leaf), mean);
      means.query.Set(means.size++, mean);
      for (int axis = 0; axis < 3; ++axis) {
        means.box.lo[axis] = std::min(means.box.lo[axis], mean[axis]);
        means.box.hi[axis] = std::max(means.box.hi[axis], mean[axis]);
      }
      last_leaf = leaf;
    }
    shared.leaf_of[m] = means.size - 1;
  }
}

// Sets the unit normal of the jet of system i where (u, v) lies in its frame, in units of rho.
inline void NormalAt(int degree, const JetSystems& jets, size_t i, double u, double v, double* normal) {
  double u_powers[kMaxJetDegree + 1] = {1.0}, v_powers[kMaxJetDegree + 1] = {1.0};
  for (int p = 1; p <= degree; ++p) {
    u_powers[p] = u_powers[p - 1] * u;
    v_powers[p] = v_powers[p - 1] * v;
  }
  double along_u = 0.0, along_v = 0.0;
  for (int p = 1; p <= degree; ++p) {
    for (int b = 0; b <= p; ++b) {
      const int a = p - b;
      const double coefficient = jets.coefficients[JetIndex(a, b)][i];
      if (a > 0) along_u += a * coefficient * u_powers[a - 1] * v_powers[b];
      if (b > 0) along_v += b * coefficient * u_powers[a] * v_powers[b - 1];
    }
  }
  double axis[3], u_axis[3], v_axis[3];
  GetVector(jets.axis, i, axis);
  GetVector(jets.u, i, u_axis);
  GetVector(jets.v, i, v_axis);
  const double per_length = 1.0 / std::sqrt(1.0 + along_u * along_u + along_v * along_v);
  for (int k = 0; k < 3; ++k) normal[k] = (axis[k] - along_u * u_axis[k] - along_v * v_axis[k]) * per_length;
}

// Gives member m what point i of the scratch came to, read at (u, v).
inline void Give(int degree, size_t i, double u, double v, size_t m, NormalScratch& s) {
  SharedFits& shared = s.shared;
  shared.members.status[m] = s.points.status[i];
  if (s.points.status[i] != PointStatus::kOk) return;
  double normal[3];
  NormalAt(degree, s.system, i, u, v, normal);
  shared.normal.Set(m, normal);
  shared.mean_square[m] = s.mean_square[i];
  shared.variance_ratio[m] = s.variance_ratio[i];
  if (s.take) s.take({m, i, u, v, {normal[0], normal[1], normal[2]}, s.mean_square[i]});
}

// Gives member m the fit of its leaf, unless there is none, or the member is too far away from the leaf's mean.
inline bool GiveShared(int degree, size_t m, NormalScratch& s) {
  const size_t i = s.shared.leaf_of[m];
  if (s.points.status[i] != PointStatus::kOk) return false;
  float mean[3], position[3];
  s.points.query.Get(i, mean);
  s.shared.members.query.Get(m, position);
  double squared = 0.0, u = 0.0, v = 0.0, u_axis[3], v_axis[3];
  GetVector(s.system.u, i, u_axis);
  GetVector(s.system.v, i, v_axis);
  for (int k = 0; k < 3; ++k) {
    const double offset = (static_cast<double>(position[k]) - mean[k]) / s.frames.rho[i];
    squared += offset * offset;
    u += offset * u_axis[k];
    v += offset * v_axis[k];
  }
  if (squared > kMostSquaredOffset) return false;
  Give(degree, i, u, v, m, s);
  return true;
}

// Fits those members of s.shared by themselves. Ends the group before the first one that is left for another run.
inline absl::Status FitAlone(const SpatialIndex& index, const NormalPlan& plan, const size_t* alone, size_t count,
                             bool lowers_degree, NormalScratch& s) {
  GroupPoints& members = s.shared.members;
  for (size_t i = 0; i < count; ++i) CopyPoint(members, alone[i], i, s.points);
  s.points.size = count;
  s.points.box = members.box;
  if (absl::Status status = FitPoints(index, plan, lowers_degree, s); !status.ok()) return status;
  for (size_t i = 0; i < s.points.size; ++i) Give(plan.degree, i, 0.0, 0.0, alone[i], s);
  if (s.points.size == count) return absl::OkStatus();
  members.size = alone[s.points.size];
  s.rest = s.first_point + members.size;
  return absl::OkStatus();
}

// Fits the points that are loaded by polynomials that those of a leaf share.
HWY_NOINLINE inline absl::Status FitShared(const SpatialIndex& index, const NormalPlan& plan, bool lowers_degree,
                                           NormalScratch& s) {
  SharedFits& shared = s.shared;
  shared.members = s.points;
  SetMeans(index, shared, s.points);
  // No run ends between the few means of a group.
  const uint64_t most_work = std::exchange(s.most_work, std::numeric_limits<uint64_t>::max());
  absl::Status status = FitPoints(index, plan, lowers_degree && plan.crosses_lines, s);
  s.most_work = most_work;
  if (!status.ok()) return status;
  size_t alone[SpatialIndex::kGroupPoints], alone_count = 0;
  for (size_t m = 0; m < shared.members.size; ++m) {
    if (!GiveShared(plan.degree, m, s)) alone[alone_count++] = m;
  }
  if (alone_count > 0) status = FitAlone(index, plan, alone, alone_count, lowers_degree, s);
  s.points = shared.members;
  s.normal = shared.normal;
  std::copy_n(shared.mean_square, s.points.size, s.mean_square);
  std::copy_n(shared.variance_ratio, s.points.size, s.variance_ratio);
  return status;
}

// Tells of each point that has its own polynomial, for whoever asked.
inline void TellFits(NormalScratch& s) {
  for (size_t i = 0; i < s.points.size; ++i) {
    if (s.points.status[i] != PointStatus::kOk) continue;
    s.take({i, i, 0.0, 0.0, {s.normal.x[i], s.normal.y[i], s.normal.z[i]}, s.mean_square[i]});
  }
}

inline absl::Status FitGroupKernel(const SpatialIndex& index, const NormalPlan& plan, size_t group, GroupSample sample,
                                   NormalScratch& s) {
  LoadGroup<true>(index, group, s.points, s.first_point);
  if (sample == GroupSample::kOneOfEachLeaf) KeepFirstOfLeaves(s.points);
  if (plan.half.has_value()) {
    KeepPoints([&](size_t i) { return HalfOf(s.points.rank[i]) == *plan.half; }, s.points);
    if (s.points.size == 0) return absl::OkStatus();
  }
  if (s.chosen != NormalScratch::kAllOfGroup) {
    const size_t first = group * SpatialIndex::kGroupPoints;
    KeepPoints([&](size_t i) { return (s.chosen >> (static_cast<size_t>(s.points.place[i]) - first) & 1) != 0; },
               s.points);
    if (s.points.size == 0) return absl::OkStatus();
  }
  // Samples tell how well a method does: by itself.
  const bool lowers_degree = sample == GroupSample::kAll;
  if (plan.shares) return FitShared(index, plan, lowers_degree, s);
  const absl::Status status = FitPoints(index, plan, lowers_degree, s);
  if (status.ok() && s.take) TellFits(s);
  return status;
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_NORMALS_FITS_GROUP_FIT_INL_H_
