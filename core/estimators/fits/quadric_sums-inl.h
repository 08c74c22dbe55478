// Sums over the neighbors of a point that a jet of degree 2 is solved from.

#if defined(CURVD_CORE_ESTIMATORS_FITS_QUADRIC_SUMS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_FITS_QUADRIC_SUMS_INL_H_
#undef CURVD_CORE_ESTIMATORS_FITS_QUADRIC_SUMS_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_FITS_QUADRIC_SUMS_INL_H_
#endif

#include "core/estimators/fits/double_sums-inl.h"
#include "core/estimators/fits/jet_systems.h"
#include "core/estimators/neighbors/neighbors.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// What SumJetInFrame (core/estimators/fits/jet-inl.h) sums for degree 2, in one pass that keeps all sums in registers:
// three times as fast where neighbors are many. The sums are those of the same numbers in another order.
// REQUIRES: the frame of point i is set; `n` is padded with zeros to a whole vector.
HWY_NOINLINE inline void SumQuadricInFrame(const NeighborArrays& n, double unit, size_t i, JetSystems& jets) {
  const DoubleTag d;
  const auto axis = [&](const GroupDoubleVectors& v) HWY_ATTR {
    return DoubleTriple{hn::Set(d, v.x[i] * unit), hn::Set(d, v.y[i] * unit), hn::Set(d, v.z[i] * unit)};
  };
  const DoubleTriple u = axis(jets.u), v = axis(jets.v), w = axis(jets.axis);
  const DoubleVec zero = hn::Zero(d);
  DoubleVec x1 = zero, y1 = zero, xx = zero, xy = zero, yy = zero, xxx = zero, xxy = zero, xyy = zero, yyy = zero;
  DoubleVec xxxx = zero, xxxy = zero, xxyy = zero, xyyy = zero, yyyy = zero;
  DoubleVec z1 = zero, zx = zero, zy = zero, zxx = zero, zxy = zero, zyy = zero;
  for (size_t j = 0; j < n.count; j += hn::Lanes(d)) {
    const DoubleTriple offset{Widen(n.dx.data() + j), Widen(n.dy.data() + j), Widen(n.dz.data() + j)};
    const DoubleVec x = Dot(offset, u), y = Dot(offset, v), z = Dot(offset, w);
    const DoubleVec p = hn::Mul(x, x), q = hn::Mul(x, y), r = hn::Mul(y, y);
    x1 = hn::Add(x1, x), y1 = hn::Add(y1, y);
    xx = hn::Add(xx, p), xy = hn::Add(xy, q), yy = hn::Add(yy, r);
    xxx = hn::MulAdd(p, x, xxx), xxy = hn::MulAdd(p, y, xxy), xyy = hn::MulAdd(r, x, xyy);
    yyy = hn::MulAdd(r, y, yyy);
    xxxx = hn::MulAdd(p, p, xxxx), xxxy = hn::MulAdd(p, q, xxxy), xxyy = hn::MulAdd(p, r, xxyy);
    xyyy = hn::MulAdd(q, r, xyyy), yyyy = hn::MulAdd(r, r, yyyy);
    z1 = hn::Add(z1, z), zx = hn::MulAdd(z, x, zx), zy = hn::MulAdd(z, y, zy);
    zxx = hn::MulAdd(z, p, zxx), zxy = hn::MulAdd(z, q, zxy), zyy = hn::MulAdd(z, r, zyy);
  }
  // In the order of JetIndex.
  double moments[16], heights[8];
  StoreFourSums(zero, x1, y1, xx, moments);
  StoreFourSums(xy, yy, xxx, xxy, moments + 4);
  StoreFourSums(xyy, yyy, xxxx, xxxy, moments + 8);
  StoreFourSums(xxyy, xyyy, yyyy, zero, moments + 12);
  StoreFourSums(z1, zx, zy, zxx, heights);
  StoreFourSums(zxy, zyy, zero, zero, heights + 4);
  moments[0] = static_cast<double>(n.count);
  for (int m = 0; m < JetSize(4); ++m) jets.moments[m][i] = moments[m];
  for (int h = 0; h < JetSize(2); ++h) jets.heights[h][i] = heights[h];
}

// What SumJetInFrame sums for degree 2, to the last bit, in one pass that keeps all sums in registers where there are
// as many. They do not depend on the order of the neighbors. REQUIRES: as SumQuadricInFrame.
HWY_NOINLINE inline void SumAnchoredQuadricInFrame(const NeighborArrays& n, double unit, size_t i, JetSystems& jets) {
  const DoubleTag d;
  const auto axis = [&](const GroupDoubleVectors& v) HWY_ATTR {
    return DoubleTriple{hn::Set(d, v.x[i] * unit), hn::Set(d, v.y[i] * unit), hn::Set(d, v.z[i] * unit)};
  };
  const DoubleTriple u = axis(jets.u), v = axis(jets.v), w = axis(jets.axis);
  const DoubleVec anchor = hn::Set(d, AnchorOf(n.count));
  DoubleVec x1 = anchor, y1 = x1, xx = x1, xy = x1, yy = x1, xxx = x1, xxy = x1, xyy = x1, yyy = x1;
  DoubleVec xxxx = x1, xxxy = x1, xxyy = x1, xyyy = x1, yyyy = x1;
  DoubleVec z1 = x1, zx = x1, zy = x1, zxx = x1, zxy = x1, zyy = x1, zz = x1;
  for (size_t j = 0; j < n.count; j += hn::Lanes(d)) {
    const DoubleTriple offset{Widen(n.dx.data() + j), Widen(n.dy.data() + j), Widen(n.dz.data() + j)};
    const DoubleVec x = Odd(Dot(offset, u)), y = Odd(Dot(offset, v)), z = Odd(Dot(offset, w));
    const DoubleVec x2 = WithLastBit(hn::Mul(x, x)), x3 = WithLastBit(hn::Mul(x2, x)), x4 = WithLastBit(hn::Mul(x3, x));
    const DoubleVec y2 = WithLastBit(hn::Mul(y, y)), y3 = WithLastBit(hn::Mul(y2, y)), y4 = WithLastBit(hn::Mul(y3, y));
    const DoubleVec z_x = WithLastBit(hn::Mul(z, x)), z_x2 = WithLastBit(hn::Mul(z_x, x));
    x1 = hn::Add(x1, x), y1 = hn::Add(y1, y);
    xx = hn::Add(xx, x2), xy = AddProduct(x, y, xy, anchor), yy = hn::Add(yy, y2);
    xxx = hn::Add(xxx, x3), xxy = AddProduct(x2, y, xxy, anchor), xyy = AddProduct(x, y2, xyy, anchor);
    yyy = hn::Add(yyy, y3);
    xxxx = hn::Add(xxxx, x4), xxxy = AddProduct(x3, y, xxxy, anchor), xxyy = AddProduct(x2, y2, xxyy, anchor);
    xyyy = AddProduct(x, y3, xyyy, anchor), yyyy = hn::Add(yyyy, y4);
    z1 = hn::Add(z1, z), zx = hn::Add(zx, z_x), zy = AddProduct(z, y, zy, anchor);
    zxx = hn::Add(zxx, z_x2), zxy = AddProduct(z_x, y, zxy, anchor), zyy = AddProduct(z, y2, zyy, anchor);
    zz = AddProduct(z, z, zz, anchor);
  }
  // In the order of JetIndex.
  double moments[16], heights[8];
  StoreAnchoredSums(zz, x1, y1, xx, anchor, moments);
  jets.squared_heights[i] = moments[0];
  StoreAnchoredSums(xy, yy, xxx, xxy, anchor, moments + 4);
  StoreAnchoredSums(xyy, yyy, xxxx, xxxy, anchor, moments + 8);
  StoreAnchoredSums(xxyy, xyyy, yyyy, zyy, anchor, moments + 12);
  StoreAnchoredSums(z1, zx, zy, zxx, anchor, heights);
  StoreAnchoredSums(zxy, zyy, zyy, zyy, anchor, heights + 4);
  moments[0] = static_cast<double>(n.count);
  for (int m = 0; m < JetSize(4); ++m) jets.moments[m][i] = moments[m];
  for (int h = 0; h < JetSize(2); ++h) jets.heights[h][i] = heights[h];
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_FITS_QUADRIC_SUMS_INL_H_
