// The star of a point in the Delaunay triangulation of points around it in the plane.
//
// Inversion about the point turns the star into a convex hull, and walking around that hull into this: from a corner a,
// the next is, of the points on one side of the line through a, the one that sees the point and a at the largest angle.
// All is decided in doubles, by operations that round alike on every instruction set.

#if defined(CURVD_CORE_ESTIMATORS_DELAUNAY_DELAUNAY_STAR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_DELAUNAY_DELAUNAY_STAR_INL_H_
#undef CURVD_CORE_ESTIMATORS_DELAUNAY_DELAUNAY_STAR_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_DELAUNAY_DELAUNAY_STAR_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/estimators/delaunay/umbrella.h"
#include "core/index/vectors-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

using DoubleTag = hn::CappedTag<double, 8>;
using DoubleVec = hn::Vec<DoubleTag>;
using DoubleMask = hn::Mask<DoubleTag>;

// Sines of angles and incircle determinants, relative to their scale, below which points are collinear or on one
// circle. Doubles leave 1e-15 of rounding; what is this near is a lattice.
inline constexpr double kPlaneTie = 1e-12;

// Points around the origin, and the walk around its star.
class DelaunayStar {
 public:
  static constexpr int kCapacity = 32;
  static_assert(kUmbrellaNeighbors < kCapacity, "the point itself may be among them");

  // Points that are no candidates have x = y = length = 0; so has the rest of the last vector.
  alignas(64) double x[kCapacity];
  alignas(64) double y[kCapacity];
  alignas(64) double length[kCapacity];
  const int32_t* id;
  int32_t own_id;  // of the origin
  int count;
  // Corners that the last walk looked for, each among all points. Whatever the points are, it ends: a step adds a
  // corner to the rim, which begins with one and has room for kMaxRim, or finds none and ends the walk to its side. The
  // second side is only walked, and ended by such a step, while there is room.
  int steps = 0;
  static constexpr int kMostSteps = Umbrella::kMaxRim;

  // Writes the rim of the star as indices of points, in the order of Umbrella::rim, and returns its size; 0 if there
  // is no triangle.
  HWY_INLINE int Walk(int* rim) {
    steps = 0;
    const int start = Nearest();
    if (start == kNone) return 0;
    int size = 1;
    rim[0] = start;
    // Where the start is less than half a turn ahead, the walk must not pass it.
    while (size < Umbrella::kMaxRim) {
      const int last = rim[size - 1];
      const int next = Next(last, 1.0, Cross(last, start) > 0.0 ? start : kNone);
      if (next == kNone) return WalkBack(rim, size);
      rim[size++] = next;
      if (next == start) break;
    }
    return size;
  }

 private:
  static constexpr int kNone = -1;
  using Bits = uint32_t;  // one a point

  HWY_INLINE double Cross(int a, int b) const { return x[a] * y[b] - y[a] * x[b]; }

  // Puts the corners clockwise from rim[0], where the star has a gap, before it. Returns the size of the whole.
  HWY_NOINLINE int WalkBack(int* rim, int size) {
    const int end = rim[size - 1];
    for (int first = rim[0]; size < Umbrella::kMaxRim; first = rim[0]) {
      const int next = Next(first, -1.0, kNone);
      if (next == kNone || next == end) break;
      std::copy_backward(rim, rim + size, rim + size + 1);
      rim[0] = next;
      ++size;
    }
    return size > 1 ? size : 0;
  }

  // The nearest point, of several the one with the lowest id: its edge is in every Delaunay triangulation.
  HWY_INLINE int Nearest() {
    const DoubleTag d;
    const DoubleVec none = hn::Set(d, std::numeric_limits<double>::infinity());
    DoubleVec least = none;
    for (int i = 0; i < count; i += Lanes()) {
      const DoubleVec l = hn::Load(d, length + i);
      const DoubleVec candidate = hn::IfThenElse(hn::Gt(l, hn::Zero(d)), l, none);
      hn::Store(candidate, d, rank_ + i);
      least = hn::Min(least, candidate);
    }
    const double nearest = hn::GetLane(hn::MinOfLanes(d, least));
    if (nearest == std::numeric_limits<double>::infinity()) return kNone;
    return LowestId(RankedAtMost(nearest * (1.0 + kPlaneTie)));
  }

  // The corner after `a` on its left (side 1) or right (side -1), or kNone; not past the corner `end`.
  HWY_INLINE int Next(int a, double side, int end) {
    ++steps;
    const DoubleTag d;
    const DoubleVec none = hn::Set(d, std::numeric_limits<double>::infinity());
    const DoubleVec ax = hn::Set(d, x[a]), ay = hn::Set(d, y[a]);
    const DoubleVec turn = hn::Set(d, side);
    const DoubleVec tie = hn::Set(d, kPlaneTie * length[a]);
    const DoubleVec end_x = hn::Set(d, end == kNone ? 0.0 : x[end]), end_y = hn::Set(d, end == kNone ? 0.0 : y[end]);
    DoubleVec least = none;
    for (int i = 0; i < count; i += Lanes()) {
      const DoubleVec px = hn::Load(d, x + i), py = hn::Load(d, y + i);
      const DoubleVec cross = hn::Mul(turn, hn::Sub(hn::Mul(ax, py), hn::Mul(ay, px)));
      const DoubleVec past = hn::Sub(hn::Mul(py, end_x), hn::Mul(px, end_y));
      const DoubleVec dot = hn::Add(hn::Mul(px, hn::Sub(px, ax)), hn::Mul(py, hn::Sub(py, ay)));
      const DoubleMask ahead = hn::And(hn::Gt(cross, hn::Mul(tie, hn::Load(d, length + i))), hn::Le(past, hn::Zero(d)));
      // The cotangent of the angle at which the candidate sees the origin and a.
      const DoubleVec cotangent = hn::IfThenElse(ahead, hn::Div(dot, cross), none);
      hn::Store(cotangent, d, rank_ + i);
      least = hn::Min(least, cotangent);
    }
    const double best = hn::GetLane(hn::MinOfLanes(d, least));
    if (best == std::numeric_limits<double>::infinity()) return kNone;
    const Bits near_ties = RankedAtMost(best + 1e-6 * (1.0 + std::abs(best)));
    if (HWY_LIKELY((near_ties & (near_ties - 1)) == 0)) return std::countr_zero(near_ties);
    return SplitTies(a, side, LowestId(RankedAtMost(best)), near_ties);
  }

  // Of the candidates on one circle with the origin, `a` and `best`, the next corner where all of them triangulate
  // their polygon as a fan from its lowest id: every point of the polygon then finds the same triangles.
  HWY_NOINLINE int SplitTies(int a, double side, int best, Bits candidates) const {
    int first = best, last = best, lowest = best;
    for (Bits rest = candidates; rest != 0; rest &= rest - 1) {
      const int c = std::countr_zero(rest);
      if (!OnCircle(a, best, c)) continue;
      if (id[c] < id[lowest]) lowest = c;
      const double before_first = side * Turn(c, first), behind_last = side * Turn(last, c);
      // Of points that coincide the one with the lowest id stands for all.
      if (before_first > 0.0 || (before_first == 0.0 && id[c] < id[first])) first = c;
      if (behind_last > 0.0 || (behind_last == 0.0 && id[c] < id[last])) last = c;
    }
    const int32_t lowest_id = std::min({own_id, id[a], id[lowest]});
    if (lowest_id == own_id) return first;
    return lowest_id == id[a] ? last : lowest;
  }

  // Positive where b lies to the left of a, 0 where in the same direction.
  double Turn(int a, int b) const {
    const double cross = Cross(a, b);
    return std::abs(cross) <= kPlaneTie * length[a] * length[b] ? 0.0 : cross;
  }

  bool OnCircle(int a, int b, int c) const {
    const double la = length[a], lb = length[b], lc = length[c];
    const double determinant = la * la * Cross(b, c) + lb * lb * Cross(c, a) + lc * lc * Cross(a, b);
    return std::abs(determinant) <= kPlaneTie * (la * lb * lc) * (la + lb + lc);
  }

  HWY_INLINE Bits RankedAtMost(double limit) const {
    const DoubleTag d;
    const DoubleVec most = hn::Set(d, limit);
    Bits bits = 0;
    for (int i = 0; i < count; i += Lanes()) {
      uint8_t lanes[8] = {};
      hn::StoreMaskBits(d, hn::Le(hn::Load(d, rank_ + i), most), lanes);
      bits |= static_cast<Bits>(lanes[0]) << i;
    }
    return bits;
  }

  HWY_INLINE int LowestId(Bits bits) const {
    int lowest = std::countr_zero(bits);
    for (bits &= bits - 1; bits != 0; bits &= bits - 1) {
      const int i = std::countr_zero(bits);
      if (id[i] < id[lowest]) lowest = i;
    }
    return lowest;
  }

  static HWY_INLINE int Lanes() { return static_cast<int>(hn::Lanes(DoubleTag())); }

  alignas(64) double rank_[kCapacity];
};

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_DELAUNAY_DELAUNAY_STAR_INL_H_
