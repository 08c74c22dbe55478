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

// Which sector of the tangent plane, 60 degrees wide around each target, each of a vector of offsets lies in.
HWY_INLINE IntVec FindSectors(FloatVec along_u, FloatVec along_v) {
  const FloatTag d;
  const IntTag di;
  const auto sector = [di](int s) HWY_ATTR { return hn::Set(di, s); };
  // The bounding lines lie at 30, 90 and 150 degrees.
  const FloatVec steep = hn::Mul(along_v, hn::Set(d, kSqrt3));
  const auto right = hn::RebindMask(di, hn::Gt(along_u, hn::Zero(d)));
  const auto above_30 = hn::RebindMask(di, hn::Gt(steep, along_u));
  const auto above_150 = hn::RebindMask(di, hn::Gt(steep, hn::Neg(along_u)));
  const IntVec on_right = hn::IfThenElse(above_30, sector(1), hn::IfThenElse(above_150, sector(0), sector(5)));
  const IntVec on_left = hn::IfThenElse(above_150, sector(2), hn::IfThenElse(above_30, sector(3), sector(4)));
  return hn::IfThenElse(right, on_right, on_left);
}

// Which step each of a vector of offsets lies in, counted from the first bound of sector 0 of the first hexagram. Those
// without a tangential part (the point itself, its doubles) lie in none: they get the step after the last.
template <int kRotations>
HWY_INLINE IntVec FindSteps(const AvgHexagramPlan& plan, FloatVec along_u, FloatVec along_v) {
  const FloatTag d;
  const IntTag di;
  const IntVec sector = FindSectors(along_u, along_v);
  IntVec step = hn::Zero(di);
  for (int r = 0; r < kRotations; ++r) step = hn::Add(step, sector);
  for (int r = 1; r < kRotations; ++r) {
    const FloatVec cosine = hn::Set(d, plan.cosine[r]), sine = hn::Set(d, plan.sine[r]);
    const IntVec turned = FindSectors(hn::MulAdd(cosine, along_u, hn::Mul(sine, along_v)),
                                      hn::NegMulAdd(sine, along_u, hn::Mul(cosine, along_v)));
    // Past the bound of the turned sector, which lies within the other.
    step = hn::Sub(step, hn::VecFromMask(di, hn::Eq(turned, sector)));
  }
  const FloatVec zero = hn::Zero(d);
  const FloatMask nowhere = hn::And(hn::Eq(along_u, zero), hn::Eq(along_v, zero));
  return hn::IfThenElse(hn::RebindMask(di, nowhere), hn::Set(di, 6 * kRotations), step);
}

// A neighbor as an integer: its row, and the step that it lies in. Only leaves with neighbors have rows: 27 bits hold
// those of 8 million neighbors, however they lie.
inline constexpr int kStepBits = 5;
static_assert(6 * kMaxRotations < 1 << kStepBits);

// Lists the neighbors of point i as `s.steps`; returns their number.
template <int kRotations>
HWY_INLINE size_t ListSteps(const SpatialIndex& index, const AvgHexagramPlan& plan, size_t i, AvgHexagramScratch& s) {
  const IntTag di;
  const Neighborhood& found = s.search.found;
  const Triple query = Broadcast(s.points.query, i), u = Broadcast(s.frames.u, i), v = Broadcast(s.frames.v, i);
  s.steps.Reserve(found.leaf_count * SpatialIndex::kLeafSize + SpatialIndex::kLeafSize);
  int32_t* out = s.steps.data();
  const auto list = [&](const NearPoints& near, FloatMask inside_floats) CURVD_INLINED {
    const FloatTag d;
    const auto inside = hn::RebindMask(di, inside_floats);
    const size_t kept = hn::CountTrue(di, inside);
    if (kept == 0) return;
    const SpatialIndex::LeafPositions& points = index.positions(near.leaf);
    const size_t lane = near.place;
    const Triple position{hn::Load(d, points.x + lane), hn::Load(d, points.y + lane), hn::Load(d, points.z + lane)};
    const Triple offset = Sub(position, query);
    const IntVec step = FindSteps<kRotations>(plan, Dot(offset, u), Dot(offset, v));
    const uint32_t first = FirstRow(index, near.leaf, found.positions[near.near], s.rows);
    const IntVec row = IntsFrom(static_cast<int32_t>(first + lane));
    hn::StoreU(hn::Compress(hn::Or(hn::ShiftLeft<kStepBits>(row), step), inside), di, out);
    out += kept;
  };
  ForEachInside(index, found, list);
  return out - s.steps.data();
}

using RowTag = hn::CappedTag<float, PointRows::kRow>;
using IntRowTag = hn::RebindToSigned<RowTag>;
inline constexpr size_t kRowParts = PointRows::kRow / hn::MaxLanes(RowTag());

// Sums over steps, twice: neighbors in turn go to either, since a sum that was just stored is late to be loaded. In
// fixed point: with each neighbor, the bits of kFixedPoint are added as well.
struct StepSums {
  static constexpr size_t kSteps = 6 * kMaxRotations + 1;
  alignas(64) int32_t row[2][kSteps][PointRows::kRow];
};

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
  const auto add = [&](int32_t listed, int32_t(*sum)[PointRows::kRow]) HWY_ATTR {
    const float* row = rows + size_t{static_cast<uint32_t>(listed) >> kStepBits} * PointRows::kRow;
    int32_t* to = sum[listed & ((1 << kStepBits) - 1)];
    for (size_t part = 0; part < kRowParts; ++part, row += hn::Lanes(d), to += hn::Lanes(d)) {
      // The difference as floats round it, since the quanta are powers of two.
      const auto quanta = hn::MulSub(hn::Load(d, row), per_quantum[part], own_quanta[part]);
      hn::Store(hn::Add(hn::Load(di, to), hn::BitCast(di, hn::Add(quanta, fixed_point))), di, to);
    }
  };
  size_t j = 0;
  for (; j + 2 <= count; j += 2) {
    add(steps[j], sums.row[0]);
    add(steps[j + 1], sums.row[1]);
  }
  if (j < count) add(steps[j], sums.row[0]);
}

// Makes the sums of both halves one, less the bits of kFixedPoint that came with each neighbor: those that the last
// numbers, which are 0, add up to.
template <int kSteps>
HWY_INLINE void JoinHalves(StepSums& sums) {
  const IntRowTag d;
  constexpr size_t kLast = PointRows::kRow - 1;
  for (int step = 0; step < kSteps; ++step) {
    int32_t *first = sums.row[0][step], *second = sums.row[1][step];
    const uint32_t bits = static_cast<uint32_t>(first[kLast]) + static_cast<uint32_t>(second[kLast]);
    for (size_t part = 0; part < kRowParts; ++part, first += hn::Lanes(d), second += hn::Lanes(d)) {
      const auto sum = hn::Add(hn::Load(d, first), hn::Load(d, second));
      hn::Store(hn::Sub(sum, hn::Set(d, static_cast<int32_t>(bits))), d, first);
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

// Sets the hexagrams of point i to the sums of their sectors.
template <int kRotations>
HWY_INLINE void FoldSteps(const RowScale& scale, StepSums& sums, size_t i, Hexagram* hexagrams) {
  constexpr int kSteps = 6 * kRotations;
  JoinHalves<kSteps>(sums);
  const RowTag d;
  const IntRowTag di;
  for (size_t c = 0; c < PointRows::kRow; c += hn::Lanes(d)) {
    const auto quantum = hn::Load(d, scale.quantum + c);
    for (int r = 0; r < kRotations; ++r) {
      for (int s = 0; s < 6; ++s) {
        auto sum = hn::Zero(di);
        for (int step = kRotations * s + r; step < kRotations * (s + 1) + r; ++step) {
          sum = hn::Add(sum, hn::Load(di, sums.row[0][step % kSteps] + c));
        }
        StoreSums(hn::Mul(hn::ConvertTo(d, sum), quantum), c, hexagrams[r].offset[s][i], hexagrams[r].normal[s][i]);
      }
    }
  }
}

// Adds up listed neighbors, `count` in all, and sets all hexagrams of point i to their sums. `own` is what `rows` are
// relative to the point by.
template <int kRotations>
HWY_INLINE void SumListed(const float* rows, size_t count, const float* own, size_t i, AvgHexagramScratch& s) {
  const IntRowTag d;
  const RowScale scale(count, s.neighborhoods.squared_radius[i], s.neighborhoods.agreement[i]);
  StepSums sums;
  for (auto& half : sums.row) {
    for (int step = 0; step <= 6 * kRotations; ++step) {
      for (size_t c = 0; c < PointRows::kRow; c += hn::Lanes(d)) hn::Store(hn::Zero(d), d, half[step] + c);
    }
  }
  AddSteps(rows, s.steps.data(), count, own, scale, sums);
  FoldSteps<kRotations>(scale, sums, i, s.hexagrams);
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
// were just found in `leaves`. Normals are summed relative to the point's own: their differences are what the measures
// need to full precision. REQUIRES: its squared radius is not 0.
HWY_NOINLINE inline void SumHexagrams(const SpatialIndex& index, const AvgHexagramPlan& plan, const LeafList& leaves,
                                      size_t i, AvgHexagramScratch& s) {
  s.rows.Start(leaves);
  float own[PointRows::kRow] = {};
  s.points.query.Get(i, own);
  s.points.normal.Get(i, own + PointRows::kNormal);
  WithRotations(plan, [&](auto rotations) CURVD_INLINED {
    const size_t count = ListSteps<rotations.value>(index, plan, i, s);
    SumListed<rotations.value>(s.rows.row(0), count, own, i, s);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_HEXAGRAM_SECTOR_SUMS_INL_H_
