// The shape operator of the field of algebraic spheres, from the sums of core/estimators/fits/algebraic_sphere-inl.h,
// where the symbols are explained.

#if defined(CURVD_CORE_ESTIMATORS_FITS_SPHERE_FIELD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_FITS_SPHERE_FIELD_INL_H_
#undef CURVD_CORE_ESTIMATORS_FITS_SPHERE_FIELD_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_FITS_SPHERE_FIELD_INL_H_
#endif

#include "core/estimators/fits/algebraic_sphere-inl.h"
#include "core/estimators/fits/double_sums-inl.h"
#include "core/estimators/fits/shape_operator-inl.h"
#include "core/estimators/fits/sphere_sums.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// Neighbors that spread less than the root of this in one tangent direction, compared with the other, may lie along a
// line.
inline constexpr float kNarrowSphereSpread = 0.05f;

// First derivatives by x of the averages of points i, i + 1, ...
struct SphereGradients {
  DoubleVec weight[3];  // of the logarithm of the sum of w
  DoubleVec p[3][3];    // [a][k]: of component k along a
  DoubleVec m[3][3];
  DoubleVec qn[3], qq[3];
};

HWY_INLINE SphereGradients LoadGradients(const SphereSums& sums, const DoubleVec* weighted, size_t i) {
  const DoubleTag d;
  const DoubleVec per_weight = hn::Div(hn::Set(d, 1.0), weighted[0]);
  SphereGradients out;
  for (int a = 0; a < 3; ++a) {
    out.weight[a] = hn::Mul(hn::Load(d, sums.gradient[a][0] + i), per_weight);
    const auto of = [&](int m) {
      return hn::Mul(hn::NegMulAdd(weighted[m], out.weight[a], hn::Load(d, sums.gradient[a][m] + i)), per_weight);
    };
    for (int k = 0; k < 3; ++k) {
      out.p[a][k] = of(1 + k);
      out.m[a][k] = of(4 + k);
    }
    out.qn[a] = of(7);
    out.qq[a] = of(8);
  }
  return out;
}

HWY_INLINE DoubleVec DotThree(const DoubleVec* a, const DoubleVec* b) {
  return hn::MulAdd(a[2], b[2], hn::MulAdd(a[1], b[1], hn::Mul(a[0], b[0])));
}

// Gradient and Hessian of the field x -> f(x) at a vector of points; the Hessian's entries are xx xy xz yy yz zz.
struct SphereField {
  DoubleVec gradient[3];
  DoubleVec hessian[6];
};

HWY_INLINE SphereField DifferentiateField(const Sphere& f, const SphereGradients& g, const SphereSums& sums, size_t i) {
  const DoubleTag d;
  const DoubleVec one = hn::Set(d, 1.0), two = hn::Set(d, 2.0), four = hn::Set(d, 4.0), half = hn::Set(d, 0.5);
  const DoubleVec p[3] = {f.p.x, f.p.y, f.p.z}, m[3] = {f.m.x, f.m.y, f.m.z};
  const DoubleVec twice_s = hn::Add(f.s, f.s);
  const DoubleVec mixed = hn::NegMulAdd(half, f.ratio, one);
  SphereField out;
  DoubleVec c[3], s[3], rest[3];  // derivatives of c and s; of the part of c that s multiplies, with B's share
  for (int a = 0; a < 3; ++a) {
    const DoubleVec p_p = DotThree(p, g.p[a]);
    const DoubleVec p_m = hn::Add(DotThree(m, g.p[a]), DotThree(p, g.m[a]));
    const DoubleVec variance = hn::NegMulAdd(two, p_p, g.qq[a]);
    s[a] = hn::Div(hn::NegMulAdd(f.s, variance, hn::Mul(half, hn::Sub(g.qn[a], p_m))), f.variance);
    const DoubleVec square = hn::NegMulAdd(four, p_p, g.qq[a]);  // of C
    c[a] = hn::NegMulAdd(f.s, square, hn::Neg(hn::MulAdd(s[a], hn::Mul(f.ratio, f.variance), p_m)));
    rest[a] = hn::MulSub(f.ratio, variance, square);
    out.gradient[a] = hn::Add(hn::NegMulAdd(twice_s, p[a], m[a]), c[a]);
  }
  int entry = 0;
  for (int a = 0; a < 3; ++a) {
    for (int b = a; b < 3; ++b, ++entry) {
      // Hess c: the weights' second derivatives, and products of first ones.
      const DoubleVec cross = hn::Add(DotThree(g.p[a], g.m[b]), DotThree(g.p[b], g.m[a]));
      DoubleVec h = hn::Load(d, sums.influence_hessian[entry] + i);
      h = hn::NegMulAdd(c[a], g.weight[b], hn::NegMulAdd(g.weight[a], c[b], h));
      h = hn::NegMulAdd(mixed, cross, h);
      h = hn::MulAdd(hn::Mul(twice_s, hn::Sub(two, f.ratio)), DotThree(g.p[a], g.p[b]), h);
      h = hn::MulAdd(s[a], rest[b], hn::MulAdd(rest[a], s[b], h));
      // grad l and its transpose.
      h = hn::Add(h, hn::Add(g.m[a][b], g.m[b][a]));
      h = hn::NegMulAdd(two, hn::MulAdd(p[a], s[b], hn::Mul(p[b], s[a])), h);
      h = hn::NegMulAdd(twice_s, hn::Add(g.p[a][b], g.p[b][a]), h);
      out.hessian[entry] = a == b ? hn::Add(h, twice_s) : h;
    }
  }
  return out;
}

// x' H y for a symmetric H
HWY_INLINE DoubleVec Bilinear(const DoubleTriple& x, const DoubleVec* h, const DoubleTriple& y) {
  return Dot(x, {Dot({h[0], h[1], h[2]}, y), Dot({h[1], h[3], h[4]}, y), Dot({h[2], h[4], h[5]}, y)});
}

// What decides whether points i, i + 1, ... have a sphere, and on which side of it is out.
struct alignas(64) SphereChecks {
  GroupDoubles variance;
  GroupDoubles spread;        // squared, of the neighbors along the narrower tangent direction over the wider, at most
  GroupDoubles outward;       // gradient times the point's normal
  GroupDoubles nearness;      // what ProjectOnSurface stores, if it is called
  GroupDoubles squared_mean;  // of the neighbors' mean normal
};

// Turns the shape operator of the level of the field that a point lies on into that of the surface, the level 0, at the
// place nearest to the point. Levels of a field whose gradient has a constant length lie at constant distances from
// each other, and their radii of curvature differ by them: with o the distance from the surface to the level, outward,
// and S the level's operator, the surface's is S (I - o S)^-1 (do Carmo, *Differential Geometry of Curves and
// Surfaces*, 1976, section 3-5). Stores the least eigenvalue of I - o S: near 0, the level is much wider than the
// surface, and far away.
HWY_INLINE void ProjectOnSurface(const Sphere& f, const DoubleTriple& gradient, ShapeOperator& s, double* nearness) {
  const DoubleTag d;
  const DoubleVec one = hn::Set(d, 1.0), half = hn::Set(d, 0.5), four = hn::Set(d, 4.0);
  const DoubleVec c = hn::Neg(hn::MulAdd(f.s, hn::Mul(f.ratio, f.variance), Dot(f.p, f.m)));
  // The distance from a sphere of this value, gradient and s.
  const DoubleVec squared = Dot(gradient, gradient);
  const DoubleVec root = hn::Sqrt(hn::Max(hn::NegMulAdd(hn::Mul(four, f.s), c, squared), hn::Zero(d)));
  const DoubleVec o = hn::Div(hn::Add(c, c), hn::Add(hn::Sqrt(squared), root));
  const DoubleVec yy = hn::NegMulAdd(o, s.yy, one), yz = hn::Neg(hn::Mul(o, s.yz)), zz = hn::NegMulAdd(o, s.zz, one);
  const DoubleVec mean = hn::Mul(half, hn::Add(yy, zz)), apart = hn::Mul(half, hn::Sub(yy, zz));
  hn::Store(hn::Sub(mean, hn::Sqrt(hn::MulAdd(apart, apart, hn::Mul(yz, yz)))), d, nearness);
  const DoubleVec per_determinant = hn::Div(one, hn::NegMulAdd(yz, yz, hn::Mul(yy, zz)));
  const DoubleVec of_yy = hn::Mul(hn::NegMulAdd(s.yz, yz, hn::Mul(s.yy, zz)), per_determinant);
  const DoubleVec of_zz = hn::Mul(hn::NegMulAdd(s.yz, yz, hn::Mul(s.zz, yy)), per_determinant);
  s.yz = hn::Mul(hn::NegMulAdd(s.yy, yz, hn::Mul(s.yz, yy)), per_determinant);
  s.yy = of_yy;
  s.zz = of_zz;
}

HWY_INLINE void SolveSpheresAt(size_t i, const SphereSums& sums, const GroupVectors& normal, bool project,
                               GroupShapes& shapes, SphereChecks& checks) {
  const DoubleTag d;
  const DoubleVec one = hn::Set(d, 1.0);
  DoubleVec weighted[SphereSums::kMoments];
  for (int m = 0; m < SphereSums::kMoments; ++m) weighted[m] = hn::Load(d, sums.weighted[m] + i);
  const Sphere sphere = FitSphere(weighted);
  const SphereField field = DifferentiateField(sphere, LoadGradients(sums, weighted, i), sums, i);
  const DoubleTriple gradient{field.gradient[0], field.gradient[1], field.gradient[2]};
  const DoubleVec per_length = hn::Div(one, hn::Sqrt(Dot(gradient, gradient)));
  const DoubleTriple n = Scale(gradient, per_length);
  ShapeOperator s;
  SetTangents(n, s);
  s.yy = hn::Mul(Bilinear(s.y, field.hessian, s.y), per_length);
  s.yz = hn::Mul(Bilinear(s.y, field.hessian, s.z), per_length);
  s.zz = hn::Mul(Bilinear(s.z, field.hessian, s.z), per_length);
  if (project) ProjectOnSurface(sphere, gradient, s, checks.nearness + i);
  StoreShapes(s, i, shapes);

  const auto second = [&](int a, int k) { return hn::Load(d, sums.gradient[a][1 + k] + i); };
  const DoubleVec moment[6] = {second(0, 0), second(0, 1), second(0, 2), second(1, 1), second(1, 2), second(2, 2)};
  const DoubleVec yy = Bilinear(s.y, moment, s.y), yz = Bilinear(s.y, moment, s.z), zz = Bilinear(s.z, moment, s.z);
  const DoubleVec trace = hn::Add(yy, zz);
  hn::Store(sphere.variance, d, checks.variance + i);
  hn::Store(Dot(sphere.m, sphere.m), d, checks.squared_mean + i);
  hn::Store(hn::Div(hn::NegMulAdd(yz, yz, hn::Mul(yy, zz)), hn::Mul(trace, trace)), d, checks.spread + i);
  const DoubleTriple own{Widen(normal.x + i), Widen(normal.y + i), Widen(normal.z + i)};
  hn::Store(Dot(gradient, own), d, checks.outward + i);
}

// Shapes of all points of the group, whose sums are set, projected on the surface if that is asked for, and
// SphereChecks::spread of each. Lowers the status of points without a sphere.
HWY_NOINLINE inline void SolveSpheres(const SphereSums& sums, bool project, GroupPoints& points, GroupShapes& shapes,
                                      GroupScalars& spread) {
  SphereChecks checks;
  for (size_t i = 0; i < points.size; i += hn::Lanes(DoubleTag())) {
    SolveSpheresAt(i, sums, points.normal, project, shapes, checks);
  }
  for (size_t i = 0; i < points.size; ++i) {
    spread[i] = static_cast<float>(checks.spread[i]);
    if (points.status[i] != PointStatus::kOk) continue;
    const bool is_near = !project || checks.nearness[i] > kLeastNearness;
    if (!(is_near && checks.variance[i] > kMinSphereVariance && checks.spread[i] > kMinSphereVariance)) {
      points.status[i] = PointStatus::kSingularFit;
    } else if (!(checks.outward[i] > 0.0) || (project && !(checks.squared_mean[i] > kLeastSquaredMean))) {
      points.status[i] = PointStatus::kInconsistentNormals;
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_FITS_SPHERE_FIELD_INL_H_
