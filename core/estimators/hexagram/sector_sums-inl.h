// Sums of the neighbors of a point over the sectors of its hexagrams.
//
// The bounds of the sectors of all hexagrams cut the tangent plane into steps of 60 / rotations degrees. A neighbor is
// added to the sum of its step alone, which is a row in memory: position, count and normal at once, one neighbor after
// the other, and nothing is left to add up over the lanes of a vector. A sector is as many steps as there are
// rotations.

#if defined(CURVD_CORE_ESTIMATORS_HEXAGRAM_SECTOR_SUMS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_HEXAGRAM_SECTOR_SUMS_INL_H_
#undef CURVD_CORE_ESTIMATORS_HEXAGRAM_SECTOR_SUMS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_HEXAGRAM_SECTOR_SUMS_INL_H_
#endif

#include <algorithm>
#include <type_traits>

#include "core/estimators/fixed_point-inl.h"
#include "core/estimators/hexagram/avg_hexagram.h"
#include "core/estimators/measures-inl.h"
#include "core/estimators/rows/point_rows-inl.h"
#include "core/search/neighborhood-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

using IntVec = hn::Vec<IntTag>;

// v + 1 where the mask is set, v elsewhere.
HWY_INLINE IntVec AddOneWhere(FloatMask mask, IntVec v) {
  const IntTag di;
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
  return hn::IfThenElse(hn::RebindMask(di, mask), hn::Add(v, hn::Set(di, 1)), v);  // one masked instruction
#else
  return hn::Sub(v, hn::VecFromMask(di, hn::RebindMask(di, mask)));
#endif
}

// Which step each of a vector of offsets lies in, counted from the bound before sector 0 of the first hexagram, which
// points down along -v. Those without a tangential part (the point itself, its doubles) lie in none: they get the step
// after the last.
template <int kRotations>
HWY_INLINE IntVec FindSteps(const AvgHexagramPlan& plan, FloatVec along_u, FloatVec along_v) {
  const FloatTag d;
  const IntTag di;
  // A bound is a line through the point. On the right, each that is passed on the way up leads to the next step; on the
  // left they come in the other order.
  IntVec passed = hn::Zero(di);
  const FloatVec opposed = hn::Neg(along_u);
  for (int pair = 0; pair < BoundPairs(kRotations); ++pair) {
    const FloatVec steep = hn::Mul(along_v, hn::Set(d, plan.cotangent[pair]));
    passed = AddOneWhere(hn::Gt(steep, opposed), AddOneWhere(hn::Gt(steep, along_u), passed));
  }
  if constexpr (kRotations % 2 == 0) passed = AddOneWhere(hn::Gt(along_v, hn::Zero(d)), passed);
  const auto right = hn::RebindMask(di, hn::Gt(along_u, hn::Zero(d)));
  const IntVec step = hn::IfThenElse(right, passed, hn::Sub(hn::Set(di, 6 * kRotations - 1), passed));
  // Without a tangential part, all bits but the signs are 0.
  return AddOneWhere(hn::Eq(hn::Or(along_u, along_v), hn::Zero(d)), step);
}

// A neighbor as an integer: its row, and the step that it lies in. 27 bits hold the rows of 8 million leaves, and so
// those of any list for 8 million neighbors: a query's own leaves hold one each, and a group lists half as many
// (SearchPlan::max_listed_leaves).
inline constexpr int kStepBits = 5;
static_assert(6 * kMaxRotations < 1 << kStepBits);

// Lists the neighbors of point i that `searching` has found as searching.steps; returns their number.
template <int kRotations>
HWY_INLINE size_t ListSteps(const SpatialIndex& index, const AvgHexagramPlan& plan, size_t i,
                            AvgHexagramScratch& searching, const AvgHexagramScratch& s) {
  const IntTag di;
  const Neighborhood& found = searching.search.found;
  const Triple query = Broadcast(s.points.query, i), u = Broadcast(s.frames.u, i), v = Broadcast(s.frames.v, i);
  searching.steps.Reserve(found.leaf_count * SpatialIndex::kLeafSize + SpatialIndex::kLeafSize);
  int32_t* out = searching.steps.data();
  // Leaves without neighbors get rows as well: whether there are any is what no branch predictor knows.
  const auto list = [&](const NearPoints& near, FloatMask inside_floats) CURVD_INLINED {
    const FloatTag d;
    const auto inside = hn::RebindMask(di, inside_floats);
    const SpatialIndex::LeafPositions& points = index.positions(near.leaf);
    const size_t lane = near.place;
    const Triple position{hn::Load(d, points.x + lane), hn::Load(d, points.y + lane), hn::Load(d, points.z + lane)};
    const Triple offset = Sub(position, query);
    const IntVec step = FindSteps<kRotations>(plan, Dot(offset, u), Dot(offset, v));
    const uint32_t first = FirstRow(index, near.leaf, near.position, searching.rows);
    const IntVec row = IntsFrom(static_cast<int32_t>(first + lane));
    hn::StoreU(hn::Compress(hn::Or(hn::ShiftLeft<kStepBits>(row), step), inside), di, out);
    out += hn::CountTrue(di, inside);
  };
  ForEachInside(index, found, list);
  return out - searching.steps.data();
}

using RowTag = hn::CappedTag<float, PointRows::kRow>;
using IntRowTag = hn::RebindToSigned<RowTag>;
inline constexpr size_t kRowParts = PointRows::kRow / hn::MaxLanes(RowTag());

// Sums over steps, several times: neighbors in turn go to each of them, since a sum that was just stored is late to be
// loaded, and neighbors in tree order lie in the same step more often than not. In fixed point: with each neighbor, the
// bits of kFixedPoint are added as well.
struct StepSums {
  static constexpr size_t kSteps = 6 * kMaxRotations + 1;
  static constexpr size_t kMostCopies = 4;
  alignas(64) int32_t row[kMostCopies][kSteps][PointRows::kRow];
};

// With fewer neighbors, clearing and joining copies takes longer than waiting for sums.
inline constexpr size_t kLeastForCopies = 100;

// How many quanta the numbers of a row have: a power of two for position and normal, 1 for the count.
struct RowScale {
  alignas(32) float per_quantum[PointRows::kRow];
  alignas(32) float quantum[PointRows::kRow];

  // For as many neighbors within a squared radius, whose normals have a cosine with the point's own of at least
  // `agreement`.
  RowScale(size_t count, float squared_radius, float agreement) {
    // What two rounded normals of unit length may differ by beyond what their cosine says, squared.
    constexpr float kRounding = 0x1p-20f;
    const int bits = FixedPointBits(count);
    const int position = bits - RootExponent(squared_radius);
    const int normal = bits - RootExponent(2.0f * std::max(1.0f - agreement, 0.0f) + kRounding);
    std::fill_n(per_quantum, 3, PowerOfTwo(position));
    std::fill_n(quantum, 3, PowerOfTwo(-position));
    per_quantum[3] = quantum[3] = 1.0f;
    std::fill_n(per_quantum + 4, 4, PowerOfTwo(normal));
    std::fill_n(quantum + 4, 4, PowerOfTwo(-normal));
  }
};

// Adds listed neighbors, less `own`, to the sums of their steps. `rows` holds theirs, by the numbers in the list.
template <size_t kCopies>
HWY_INLINE void AddSteps(const float* rows, const int32_t* steps, size_t count, const float* own, const RowScale& scale,
                         StepSums& sums) {
  const RowTag d;
  const IntRowTag di;
  const auto fixed_point = hn::Set(d, kFixedPoint);
  hn::Vec<RowTag> per_quantum[kRowParts], own_quanta[kRowParts];
  for (size_t part = 0; part < kRowParts; ++part) {
    per_quantum[part] = hn::Load(d, scale.per_quantum + part * hn::Lanes(d));
    own_quanta[part] = hn::Mul(hn::LoadU(d, own + part * hn::Lanes(d)), per_quantum[part]);
  }
  const auto* const bytes = reinterpret_cast<const uint8_t*>(rows);
  const auto add = [&](int32_t listed, int32_t(*sum)[PointRows::kRow]) HWY_ATTR {
    constexpr uint32_t kStepMask = (1u << kStepBits) - 1;
    const auto bits = static_cast<uint32_t>(listed);
    // The number of the row times its bytes.
    static_assert(sizeof(float) * PointRows::kRow == 1 << kStepBits);
    const auto* row = reinterpret_cast<const float*>(bytes + (bits & ~kStepMask));
    int32_t* to = sum[bits & kStepMask];
    for (size_t part = 0; part < kRowParts; ++part, row += hn::Lanes(d), to += hn::Lanes(d)) {
      // The difference as floats round it, since the quanta are powers of two.
      const auto quanta = hn::MulSub(hn::Load(d, row), per_quantum[part], own_quanta[part]);
      hn::Store(hn::Add(hn::Load(di, to), hn::BitCast(di, hn::Add(quanta, fixed_point))), di, to);
    }
  };
  size_t j = 0;
  for (; j + kCopies <= count; j += kCopies) {
    for (size_t copy = 0; copy < kCopies; ++copy) add(steps[j + copy], sums.row[copy]);
  }
  for (size_t copy = 0; j + copy < count; ++copy) add(steps[j + copy], sums.row[copy]);
}

// Makes the sums of all copies one, less the bits of kFixedPoint that came with each neighbor: those that the last
// numbers, which are 0, add up to.
template <int kSteps, size_t kCopies>
HWY_INLINE void JoinCopies(StepSums& sums) {
  const IntRowTag d;
  constexpr size_t kLast = PointRows::kRow - 1;
  for (int step = 0; step < kSteps; ++step) {
    uint32_t bits = 0;
    for (size_t copy = 0; copy < kCopies; ++copy) bits += static_cast<uint32_t>(sums.row[copy][step][kLast]);
    for (size_t c = 0; c < PointRows::kRow; c += hn::Lanes(d)) {
      auto sum = hn::Load(d, sums.row[0][step] + c);
      for (size_t copy = 1; copy < kCopies; ++copy) sum = hn::Add(sum, hn::Load(d, sums.row[copy][step] + c));
      hn::Store(hn::Sub(sum, hn::Set(d, static_cast<int32_t>(bits))), d, sums.row[0][step] + c);
    }
  }
}

// Stores a part of a row of sums, from number c on.
HWY_INLINE void StoreSums(hn::Vec<RowTag> sums, [[maybe_unused]] size_t c, float* offset, float* normal) {
  const RowTag d;
#if HWY_TARGET != HWY_SCALAR
  if constexpr (kRowParts == 1) {
    const hn::Half<RowTag> half;
    hn::Store(hn::LowerHalf(half, sums), half, offset);
    hn::Store(hn::UpperHalf(half, sums), half, normal);
    return;
  }
#endif
  hn::Store(sums, d, c < PointRows::kNormal ? offset + c : normal + (c - PointRows::kNormal));
}

// Sets the hexagrams of point i to the sums of their sectors. The first copy of the sums has all.
template <int kRotations>
HWY_INLINE void FoldSteps(const RowScale& scale, const StepSums& sums, size_t i, Hexagram* hexagrams) {
  constexpr int kSteps = 6 * kRotations;
  const RowTag d;
  const IntRowTag di;
  for (size_t c = 0; c < PointRows::kRow; c += hn::Lanes(d)) {
    const auto quantum = hn::Load(d, scale.quantum + c);
    for (int r = 0; r < kRotations; ++r) {
      for (int s = 0; s < 6; ++s) {
        auto sum = hn::Zero(di);
        for (int step = kRotations * (s + 1) + r; step < kRotations * (s + 2) + r; ++step) {
          sum = hn::Add(sum, hn::Load(di, sums.row[0][step % kSteps] + c));
        }
        StoreSums(hn::Mul(hn::ConvertTo(d, sum), quantum), c, hexagrams[r].offset[s][i], hexagrams[r].normal[s][i]);
      }
    }
  }
}

// Adds up listed neighbors, `count` in all, in so many copies, and sets all hexagrams of point i to their sums.
template <int kRotations, size_t kCopies>
HWY_INLINE void SumInCopies(const float* rows, const int32_t* steps, size_t count, const float* own,
                            const RowScale& scale, size_t i, Hexagram* hexagrams) {
  const IntRowTag d;
  constexpr int kSteps = 6 * kRotations;
  StepSums sums;
  for (size_t copy = 0; copy < kCopies; ++copy) {
    for (int step = 0; step <= kSteps; ++step) {
      for (size_t c = 0; c < PointRows::kRow; c += hn::Lanes(d)) hn::Store(hn::Zero(d), d, sums.row[copy][step] + c);
    }
  }
  AddSteps<kCopies>(rows, steps, count, own, scale, sums);
  JoinCopies<kSteps, kCopies>(sums);
  FoldSteps<kRotations>(scale, sums, i, hexagrams);
}

// Calls `sum` with a constant, the number of rotations.
template <typename Sum>
HWY_INLINE void WithRotations(const AvgHexagramPlan& plan, Sum sum) {
  static_assert(kMaxRotations == 4);
  switch (plan.rotations) {
    case 1:
      return sum(std::integral_constant<int, 1>());
    case 2:
      return sum(std::integral_constant<int, 2>());
    case 3:
      return sum(std::integral_constant<int, 3>());
    default:
      return sum(std::integral_constant<int, 4>());
  }
}

// Sets all hexagrams of point i, turned evenly between one sector and the next, to the sums of its neighbors, which
// `searching`, the scratch itself or that of the largest of several scales, has just found in `leaves`. Normals are
// summed relative to the point's own: their differences are what the measures need to full precision. REQUIRES: its
// squared radius is not 0.
HWY_NOINLINE inline void SumHexagrams(const SpatialIndex& index, const AvgHexagramPlan& plan, const LeafList& leaves,
                                      size_t i, AvgHexagramScratch& searching, AvgHexagramScratch& s) {
  searching.rows.Start(leaves);
  float own[PointRows::kRow] = {};
  s.points.query.Get(i, own);
  s.points.normal.Get(i, own + PointRows::kNormal);
  WithRotations(plan, [&](auto rotations) CURVD_INLINED {
    constexpr int kRotations = rotations.value;
    const size_t count = ListSteps<kRotations>(index, plan, i, searching, s);
    const RowScale scale(count, s.neighborhoods.squared_radius[i], s.neighborhoods.agreement[i]);
    const float* const rows = searching.rows.row(0);
    const int32_t* const steps = searching.steps.data();
    count < kLeastForCopies
        ? SumInCopies<kRotations, 2>(rows, steps, count, own, scale, i, s.hexagrams)
        : SumInCopies<kRotations, StepSums::kMostCopies>(rows, steps, count, own, scale, i, s.hexagrams);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_HEXAGRAM_SECTOR_SUMS_INL_H_
