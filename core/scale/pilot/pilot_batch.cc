#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/scale/pilot/pilot_batch.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/scale/pilot/pilot_batch.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr size_t kParts = PilotBatch::kParts;
using PartTag = hn::CappedTag<double, kParts>;
using PartVec = hn::Vec<PartTag>;

// Multiplies a monomial of every neighbor by x or y, and adds up the products, these times heights, and these times
// normals. REQUIRES: `padded` is a multiple of kParts.
template <bool kHeights, bool kNormals>
HWY_INLINE void AddMonomial(const double* factor, const double* from, double* to, const PilotBatch& batch,
                            size_t padded, size_t place, const PilotMoments& sums) {
  const PartTag d;
  alignas(64) double plain[kParts], height[kParts], nx[kParts], ny[kParts], nz[kParts];
  // Operations are not fused: not every machine can.
  const auto add_product = [&](PartVec sum, PartVec value, const PilotBatch::Column& column, size_t k)
                               HWY_ATTR { return hn::Add(sum, hn::Mul(value, hn::Load(d, column.data() + k))); };
  for (size_t part = 0; part < kParts; part += hn::Lanes(d)) {
    PartVec plain_sum = hn::Zero(d), height_sum = plain_sum, nx_sum = plain_sum, ny_sum = plain_sum, nz_sum = plain_sum;
    for (size_t k = part; k < padded; k += kParts) {
      const PartVec value = hn::Mul(hn::Load(d, factor + k), hn::Load(d, from + k));
      hn::Store(value, d, to + k);
      plain_sum = hn::Add(plain_sum, value);
      if constexpr (kHeights) height_sum = add_product(height_sum, value, batch.offset[2], k);
      if constexpr (kNormals) {
        nx_sum = add_product(nx_sum, value, batch.normal[0], k);
        ny_sum = add_product(ny_sum, value, batch.normal[1], k);
        nz_sum = add_product(nz_sum, value, batch.normal[2], k);
      }
    }
    hn::Store(plain_sum, d, plain + part);
    hn::Store(height_sum, d, height + part);
    hn::Store(nx_sum, d, nx + part);
    hn::Store(ny_sum, d, ny + part);
    hn::Store(nz_sum, d, nz + part);
  }
  sums.plain[place] += PilotBatch::Total(plain);
  if constexpr (kHeights) sums.height[place] += PilotBatch::Total(height);
  if constexpr (kNormals) {
    sums.normal[0][place] += PilotBatch::Total(nx);
    sums.normal[1][place] += PilotBatch::Total(ny);
    sums.normal[2][place] += PilotBatch::Total(nz);
  }
}

// The same for what is asked of the monomials of a degree.
HWY_INLINE void AddMonomial(size_t degree, const double* factor, const double* from, double* to,
                            const PilotBatch& batch, size_t padded, size_t place, const PilotMoments& sums) {
  const bool has_heights = sums.height != nullptr;
  if (degree <= static_cast<size_t>(sums.normal_degree)) {
    has_heights ? AddMonomial<true, true>(factor, from, to, batch, padded, place, sums)
                : AddMonomial<false, true>(factor, from, to, batch, padded, place, sums);
  } else if (has_heights && degree <= static_cast<size_t>(sums.degree)) {
    AddMonomial<true, false>(factor, from, to, batch, padded, place, sums);
  } else {
    AddMonomial<false, false>(factor, from, to, batch, padded, place, sums);
  }
}

void AddMomentsKernel(PilotBatch& batch, const PilotMoments& sums) {
  // Of every neighbor, the monomials of one degree.
  alignas(64) double row[2 * PilotMoments::kMostDegree + 1][PilotBatch::kMost];
  const size_t padded = batch.Pad();
  const double* const one = batch.one.data();
  const double* const x = batch.offset[0].data();
  const double* const y = batch.offset[1].data();
  AddMonomial(0, one, one, row[0], batch, padded, 0, sums);
  size_t place = 1;
  for (size_t n = 1; n <= 2 * static_cast<size_t>(sums.degree); ++n, place += n) {
    AddMonomial(n, y, row[n - 1], row[n], batch, padded, place + n, sums);
    for (size_t j = 0; j < n; ++j) AddMonomial(n, x, row[j], row[j], batch, padded, place + j, sums);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace curvd {
namespace {

HWY_EXPORT(AddMomentsKernel);

}  // namespace

void AddMoments(PilotBatch& batch, const PilotMoments& sums) {
  if (batch.count > 0) HWY_DYNAMIC_DISPATCH(AddMomentsKernel)(batch, sums);
}

}  // namespace curvd

#endif  // HWY_ONCE
