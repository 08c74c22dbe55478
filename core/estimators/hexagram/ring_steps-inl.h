// Sums of collected neighbors over the sectors of hexagrams, for estimates at several scales.

#if defined(CURVD_CORE_ESTIMATORS_HEXAGRAM_RING_STEPS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_HEXAGRAM_RING_STEPS_INL_H_
#undef CURVD_CORE_ESTIMATORS_HEXAGRAM_RING_STEPS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_HEXAGRAM_RING_STEPS_INL_H_
#endif

#include "core/estimators/hexagram/sector_sums-inl.h"
#include "core/estimators/scales/ring_neighbors.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Writes a row for each neighbor, whose position is its offset from the point.
HWY_INLINE void WriteRingRows(const NeighborArrays& n, PointRows& rows) {
  float* out = rows.Restart(n.count + NeighborArrays::kPad);
#if HWY_TARGET == HWY_SCALAR
  for (size_t j = 0; j < n.count; ++j) {
    const float row[PointRows::kRow] = {n.dx[j], n.dy[j], n.dz[j], 1.0f, n.nx[j], n.ny[j], n.nz[j], 0.0f};
    std::copy(row, row + PointRows::kRow, out + j * PointRows::kRow);
  }
#else
  // Zeros follow the last neighbor.
  for (size_t j = 0; j < n.count; j += 4) {
    WriteColumns(n.dx.data() + j, n.dy.data() + j, n.dz.data() + j, 1.0f, out + j * PointRows::kRow);
    WriteColumns(n.nx.data() + j, n.ny.data() + j, n.nz.data() + j, 0.0f, out + j * PointRows::kRow + 4);
  }
#endif
}

// Sets all hexagrams of point i to the sums of the neighbors in `ring`: the same as SumHexagrams makes of them.
// REQUIRES: `rows` were written of the largest ring; its squared radius is not 0.
HWY_NOINLINE inline void SumRing(const AvgHexagramPlan& plan, const RingNeighbors& ring, PointRows& rows, size_t i,
                                 AvgHexagramScratch& s) {
  const FloatTag d;
  const IntTag di;
  const NeighborArrays& n = ring.neighbors;
  const Triple u = Broadcast(s.frames.u, i), v = Broadcast(s.frames.v, i);
  s.steps.Reserve(n.count + SpatialIndex::kLeafSize);
  float own[PointRows::kRow] = {};
  s.points.normal.Get(i, own + PointRows::kNormal);
  WithRotations(plan, [&](auto rotations) CURVD_INLINED {
    for (size_t j = 0; j < n.count; j += hn::Lanes(d)) {
      const Triple offset{hn::Load(d, n.dx.data() + j), hn::Load(d, n.dy.data() + j), hn::Load(d, n.dz.data() + j)};
      const IntVec step = FindSteps<rotations.value>(plan, Dot(offset, u), Dot(offset, v));
      const IntVec row = hn::Load(di, ring.number.data() + j);
      hn::StoreU(hn::Or(hn::ShiftLeft<kStepBits>(row), step), di, s.steps.data() + j);
    }
    SumListed<rotations.value>(rows.row(0), n.count, own, i, s);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_HEXAGRAM_RING_STEPS_INL_H_
