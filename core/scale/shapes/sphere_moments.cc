#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/scale/shapes/sphere_moments.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/scale/shapes/sphere_moments.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using SphereTag = hn::CappedTag<double, PilotBatch::kParts>;
using SphereVec = hn::Vec<SphereTag>;

// Adds the products of one left factor with all right ones to `sums`. Operations are not fused: not every machine can.
HWY_INLINE void AddProducts(const double* left, const double* const* rights, size_t padded, double* sums) {
  const SphereTag d;
  constexpr size_t kParts = PilotBatch::kParts;
  alignas(64) double parts[SphereMoments::kRights][kParts];
  for (size_t part = 0; part < kParts; part += hn::Lanes(d)) {
    SphereVec s0 = hn::Zero(d), s1 = s0, s2 = s0, s3 = s0, s4 = s0, s5 = s0, s6 = s0, s7 = s0;
    for (size_t k = part; k < padded; k += kParts) {
      const SphereVec factor = hn::Load(d, left + k);
      const auto product = [&](size_t right) HWY_ATTR { return hn::Mul(factor, hn::Load(d, rights[right] + k)); };
      s0 = hn::Add(s0, product(0)), s1 = hn::Add(s1, product(1));
      s2 = hn::Add(s2, product(2)), s3 = hn::Add(s3, product(3));
      s4 = hn::Add(s4, product(4)), s5 = hn::Add(s5, product(5));
      s6 = hn::Add(s6, product(6)), s7 = hn::Add(s7, product(7));
    }
    hn::Store(s0, d, parts[0] + part), hn::Store(s1, d, parts[1] + part);
    hn::Store(s2, d, parts[2] + part), hn::Store(s3, d, parts[3] + part);
    hn::Store(s4, d, parts[4] + part), hn::Store(s5, d, parts[5] + part);
    hn::Store(s6, d, parts[6] + part), hn::Store(s7, d, parts[7] + part);
  }
  for (size_t right = 0; right < SphereMoments::kRights; ++right) sums[right] += PilotBatch::Total(parts[right]);
}

void AddSphereMoments(PilotBatch& batch, double* sums, double* sixth) {
  using M = SphereMoments;
  constexpr size_t kParts = PilotBatch::kParts;
  const SphereTag d;
  const size_t padded = batch.Pad();
  alignas(64) double made[M::kLefts][PilotBatch::kMost];
  alignas(64) double offset_normal[PilotBatch::kMost], sixths[kParts] = {};
  const double *const x = batch.offset[0].data(), *const y = batch.offset[1].data(), *const z = batch.offset[2].data();
  for (size_t k = 0; k < padded; k += hn::Lanes(d)) {
    const SphereVec q[3] = {hn::Load(d, x + k), hn::Load(d, y + k), hn::Load(d, z + k)};
    SphereVec product[6];
    size_t place = 0;
    for (size_t a = 0; a < 3; ++a) {
      for (size_t b = a; b < 3; ++b) product[place++] = hn::Mul(q[a], q[b]);
    }
    const SphereVec squared = hn::Add(hn::Add(product[0], product[3]), product[5]);
    const SphereVec fourth = hn::Mul(squared, squared);
    hn::Store(squared, d, made[M::kSquared] + k);
    hn::Store(fourth, d, made[M::kFourth] + k);
    for (size_t a = 0; a < 3; ++a) hn::Store(hn::Mul(squared, q[a]), d, made[M::kCubic + a] + k);
    for (size_t p = 0; p < 6; ++p) hn::Store(product[p], d, made[M::kProducts + p] + k);
    const auto along = [&](size_t a) HWY_ATTR { return hn::Mul(q[a], hn::Load(d, batch.normal[a].data() + k)); };
    hn::Store(hn::Add(hn::Add(along(0), along(1)), along(2)), d, offset_normal + k);
    double* const sixth_part = sixths + k % kParts;
    hn::Store(hn::Add(hn::Load(d, sixth_part), hn::Mul(squared, fourth)), d, sixth_part);
  }
  *sixth += PilotBatch::Total(sixths);
  const double* const rights[M::kRights] = {
      batch.one.data(), x, y, z, batch.normal[0].data(), batch.normal[1].data(), batch.normal[2].data(), offset_normal};
  const double* lefts[M::kLefts] = {batch.one.data()};
  for (size_t left = 1; left < M::kLefts; ++left) lefts[left] = made[left];
  for (size_t a = 0; a < 3; ++a) lefts[M::kLinear + a] = rights[M::kOffset + a];
  for (size_t left = 0; left < M::kLefts; ++left) AddProducts(lefts[left], rights, padded, sums + left * M::kRights);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace curvd {
namespace {

HWY_EXPORT(AddSphereMoments);

}  // namespace

void SphereMoments::Add(PilotBatch& batch) {
  if (batch.count > 0) HWY_DYNAMIC_DISPATCH(AddSphereMoments)(batch, values_.data(), &values_[kSixth]);
}

SphereMoments& SphereMoments::operator+=(const SphereMoments& other) {
  for (size_t i = 0; i < values_.size(); ++i) values_[i] += other.values_[i];
  return *this;
}

}  // namespace curvd

#endif  // HWY_ONCE
