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

#include "core/estimators/hexagram/avg_hexagram.h"
#include "core/estimators/measures-inl.h"
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
HWY_INLINE IntVec FindSteps(const AvgHexagramPlan& plan, FloatVec along_u, FloatVec along_v) {
  const FloatTag d;
  const IntTag di;
  const IntVec sector = FindSectors(along_u, along_v);
  IntVec step = hn::Zero(di);
  for (int r = 0; r < plan.rotations; ++r) step = hn::Add(step, sector);
  for (int r = 1; r < plan.rotations; ++r) {
    const FloatVec cosine = hn::Set(d, plan.cosine[r]), sine = hn::Set(d, plan.sine[r]);
    const IntVec turned = FindSectors(hn::MulAdd(cosine, along_u, hn::Mul(sine, along_v)),
                                      hn::NegMulAdd(sine, along_u, hn::Mul(cosine, along_v)));
    // Past the bound of the turned sector, which lies within the other.
    step = hn::Sub(step, hn::VecFromMask(di, hn::Eq(turned, sector)));
  }
  const FloatVec zero = hn::Zero(d);
  const FloatMask nowhere = hn::And(hn::Eq(along_u, zero), hn::Eq(along_v, zero));
  return hn::IfThenElse(hn::RebindMask(di, nowhere), hn::Set(di, 6 * plan.rotations), step);
}

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE void WriteRows(const SpatialIndex::LeafPositions& points, const SpatialIndex::LeafNormals& normals,
                          float* rows) {
  for (size_t i = 0; i < SpatialIndex::kLeafSize; ++i) {
    const float row[PointRows::kRow] = {points.x[i],  points.y[i],  points.z[i],  1.0f,
                                        normals.x[i], normals.y[i], normals.z[i], 0.0f};
    std::copy(row, row + PointRows::kRow, rows + i * PointRows::kRow);
  }
}

#else

// Writes four columns of four rows.
HWY_INLINE void WriteColumns(const float* x, const float* y, const float* z, float last, float* rows) {
  const hn::FixedTag<float, 4> d;
  const auto vx = hn::Load(d, x), vy = hn::Load(d, y), vz = hn::Load(d, z), vw = hn::Set(d, last);
  const auto xy_01 = hn::InterleaveLower(d, vx, vy), xy_23 = hn::InterleaveUpper(d, vx, vy);
  const auto zw_01 = hn::InterleaveLower(d, vz, vw), zw_23 = hn::InterleaveUpper(d, vz, vw);
  hn::Store(hn::ConcatLowerLower(d, zw_01, xy_01), d, rows);
  hn::Store(hn::ConcatUpperUpper(d, zw_01, xy_01), d, rows + PointRows::kRow);
  hn::Store(hn::ConcatLowerLower(d, zw_23, xy_23), d, rows + 2 * PointRows::kRow);
  hn::Store(hn::ConcatUpperUpper(d, zw_23, xy_23), d, rows + 3 * PointRows::kRow);
}

HWY_INLINE void WriteRows(const SpatialIndex::LeafPositions& points, const SpatialIndex::LeafNormals& normals,
                          float* rows) {
  for (size_t i = 0; i < SpatialIndex::kLeafSize; i += 4) {
    WriteColumns(points.x + i, points.y + i, points.z + i, 1.0f, rows + i * PointRows::kRow);
    WriteColumns(normals.x + i, normals.y + i, normals.z + i, 0.0f, rows + i * PointRows::kRow + 4);
  }
}

#endif

// The first row of a leaf at a position of the list, which is written unless it has been.
HWY_INLINE uint32_t FirstRow(const SpatialIndex& index, uint32_t leaf, uint32_t position, PointRows& rows) {
  const uint32_t known = rows.first(position);
  if (HWY_LIKELY(known != PointRows::kNone)) return known;
  const uint32_t first = rows.Add(position);
  WriteRows(index.positions(leaf), index.normals(leaf), rows.row(first));
  return first;
}

// A neighbor as an integer: its row, and the step that it lies in. Only leaves with neighbors have rows: 27 bits hold
// those of 8 million neighbors, however they lie.
inline constexpr int kStepBits = 5;
static_assert(6 * kMaxRotations < 1 << kStepBits);

// Lists the neighbors of point i as `s.steps`; returns their number.
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
    const IntVec step = FindSteps(plan, Dot(offset, u), Dot(offset, v));
    const uint32_t first = FirstRow(index, near.leaf, found.positions[near.near], s.rows);
    const IntVec row = IntsFrom(static_cast<int32_t>(first + lane));
    hn::StoreU(hn::Compress(hn::Or(hn::ShiftLeft<kStepBits>(row), step), inside), di, out);
    out += kept;
  };
  ForEachInside(index, found, list);
  return out - s.steps.data();
}

using RowTag = hn::CappedTag<float, PointRows::kRow>;
inline constexpr size_t kRowParts = PointRows::kRow / hn::MaxLanes(RowTag());

// Sums over steps, twice: neighbors in turn go to either, since a sum that was just stored is late to be loaded.
struct StepSums {
  static constexpr size_t kSteps = 6 * kMaxRotations + 1;
  alignas(64) float row[2][kSteps][PointRows::kRow];
};

// Adds listed neighbors, less `own`, to the sums of their steps.
HWY_INLINE void AddSteps(const PointRows& rows, const int32_t* steps, size_t count, const hn::Vec<RowTag>* own,
                         StepSums& sums) {
  const RowTag d;
  const auto add = [&](int32_t listed, float(*sum)[PointRows::kRow]) HWY_ATTR {
    const float* row = rows.row(static_cast<uint32_t>(listed) >> kStepBits);
    float* to = sum[listed & ((1 << kStepBits) - 1)];
    for (size_t part = 0; part < kRowParts; ++part, row += hn::Lanes(d), to += hn::Lanes(d)) {
      hn::Store(hn::Add(hn::Load(d, to), hn::Sub(hn::Load(d, row), own[part])), d, to);
    }
  };
  size_t j = 0;
  for (; j + 2 <= count; j += 2) {
    add(steps[j], sums.row[0]);
    add(steps[j + 1], sums.row[1]);
  }
  if (j < count) add(steps[j], sums.row[0]);
}

// Sets the hexagrams of point i to the sums of their sectors.
template <int kRotations>
HWY_INLINE void FoldSteps(StepSums& sums, size_t i, Hexagram* hexagrams) {
  const RowTag d;
  constexpr int kSteps = 6 * kRotations;
  for (int step = 0; step < kSteps; ++step) {
    float *first = sums.row[0][step], *second = sums.row[1][step];
    for (size_t part = 0; part < kRowParts; ++part, first += hn::Lanes(d), second += hn::Lanes(d)) {
      hn::Store(hn::Add(hn::Load(d, first), hn::Load(d, second)), d, first);
    }
  }
  const hn::CappedTag<float, 4> half;
  for (int r = 0; r < kRotations; ++r) {
    for (int s = 0; s < 6; ++s) {
      for (size_t c = 0; c < 4; c += hn::Lanes(half)) {
        auto offset = hn::Zero(half), normal = hn::Zero(half);
        for (int step = kRotations * s + r; step < kRotations * (s + 1) + r; ++step) {
          const float* row = sums.row[0][step % kSteps] + c;
          offset = hn::Add(offset, hn::Load(half, row));
          normal = hn::Add(normal, hn::Load(half, row + 4));
        }
        hn::Store(offset, half, hexagrams[r].offset[s][i] + c);
        hn::Store(normal, half, hexagrams[r].normal[s][i] + c);
      }
    }
  }
}

// Sets all hexagrams of point i, turned evenly between one sector and the next, to the sums of its neighbors, which
// were just found in `leaves`. Normals are summed relative to the point's own: their differences are what the measures
// need to full precision.
HWY_NOINLINE inline void SumHexagrams(const SpatialIndex& index, const AvgHexagramPlan& plan, const LeafList& leaves,
                                      size_t i, AvgHexagramScratch& s) {
  const RowTag d;
  s.rows.Start(leaves);
  const size_t count = ListSteps(index, plan, i, s);
  float own_row[PointRows::kRow] = {};
  s.points.query.Get(i, own_row);
  s.points.normal.Get(i, own_row + 4);
  hn::Vec<RowTag> own[kRowParts];
  for (size_t part = 0; part < kRowParts; ++part) own[part] = hn::LoadU(d, own_row + part * hn::Lanes(d));
  StepSums sums;
  for (auto& half : sums.row) {
    for (int step = 0; step <= 6 * plan.rotations; ++step) {
      for (size_t c = 0; c < PointRows::kRow; c += hn::Lanes(d)) hn::Store(hn::Zero(d), d, half[step] + c);
    }
  }
  AddSteps(s.rows, s.steps.data(), count, own, sums);
  switch (plan.rotations) {
    case 1:
      return FoldSteps<1>(sums, i, s.hexagrams);
    case 2:
      return FoldSteps<2>(sums, i, s.hexagrams);
    case 3:
      return FoldSteps<3>(sums, i, s.hexagrams);
    default:
      return FoldSteps<kMaxRotations>(sums, i, s.hexagrams);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_HEXAGRAM_SECTOR_SUMS_INL_H_
