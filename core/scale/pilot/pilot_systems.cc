#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/scale/pilot/pilot_systems.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Must come after foreach_target.h.
#include "core/scale/pilot/pilot_systems.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr size_t kLanes = PilotSystems::kLanes;
using LaneTag = hn::CappedTag<double, kLanes>;
using LaneVec = hn::Vec<LaneTag>;

// Pivots of normal equations below this, where 1 is what an even neighborhood has, are rounding errors.
constexpr double kLeastPivot = 1e-10;

// A vector in memory.
struct Stored {
  alignas(64) double lanes[hn::MaxLanes(LaneTag())];

  HWY_INLINE LaneVec Get() const { return hn::Load(LaneTag(), lanes); }
  HWY_INLINE void Set(LaneVec v) { hn::Store(v, LaneTag(), lanes); }
};

// The Cholesky factors of symmetric matrices of one size, one in each lane.
template <int kSize>
class LaneCholesky {
 public:
  // Where the lower triangle of the matrix goes.
  Stored& at(int row, int column) { return lower_[column][row]; }

  // Returns where every pivot is above kLeastPivot; NaN is not.
  HWY_INLINE hn::Mask<LaneTag> Compute() {
    const LaneTag d;
    const LaneVec one = hn::Set(d, 1.0), least = hn::Set(d, kLeastPivot);
    auto are_fixed = hn::Eq(one, one);
    for (int k = 0; k < kSize; ++k) {
      Stored* const pivots = lower_[k];
      const LaneVec pivot = pivots[k].Get();
      const auto is_large = hn::Gt(pivot, least);
      are_fixed = hn::And(are_fixed, is_large);
      const LaneVec inverse = hn::Div(one, hn::Sqrt(hn::IfThenElse(is_large, pivot, one)));
      inverse_[k].Set(inverse);
      for (int row = k + 1; row < kSize; ++row) pivots[row].Set(hn::Mul(pivots[row].Get(), inverse));
      for (int column = k + 1; column < kSize; ++column) {
        const LaneVec factor = pivots[column].Get();
        Stored* const other = lower_[column];
        for (int row = column; row < kSize; ++row) {
          other[row].Set(hn::Sub(other[row].Get(), hn::Mul(factor, pivots[row].Get())));
        }
      }
    }
    return are_fixed;
  }

  HWY_INLINE void Solve(Stored* right) const {
    for (int k = 0; k < kSize; ++k) {
      const LaneVec solved = hn::Mul(right[k].Get(), inverse_[k].Get());
      right[k].Set(solved);
      for (int row = k + 1; row < kSize; ++row) {
        right[row].Set(hn::Sub(right[row].Get(), hn::Mul(solved, lower_[k][row].Get())));
      }
    }
    for (int k = kSize - 1; k >= 0; --k) {
      LaneVec sum = right[k].Get();
      for (int row = k + 1; row < kSize; ++row) sum = hn::Sub(sum, hn::Mul(right[row].Get(), lower_[k][row].Get()));
      right[k].Set(hn::Mul(sum, inverse_[k].Get()));
    }
  }

 private:
  Stored lower_[kSize][kSize];  // column by column
  Stored inverse_[kSize];       // of the factors' diagonals
};

// Loads sums of monomials up to `degree`, of lengths in units of the radius, divided by the count.
HWY_INLINE void Normalize(const double* sums, int degree, LaneVec inverse_count, LaneVec radius, Stored* out) {
  const LaneTag d;
  LaneVec factor = inverse_count;
  for (int n = 0, place = 0; n <= degree; ++n) {
    for (int j = 0; j <= n; ++j, ++place) {
      out[place].Set(hn::Mul(hn::Load(d, sums + static_cast<size_t>(place) * kLanes), factor));
    }
    factor = hn::Div(factor, radius);
  }
}

// The sums of (1 - x^2 - y^2) times monomials up to `degree`, of those of monomials alone, in their place.
HWY_INLINE void Weigh(Stored* sums, int degree) {
  for (int n = 0; n <= degree; ++n) {
    for (int j = 0; j <= n; ++j) {
      const int i = n - j;
      Stored& sum = sums[IndexOf(i, j)];
      sum.Set(hn::Sub(hn::Sub(sum.Get(), sums[IndexOf(i + 2, j)].Get()), sums[IndexOf(i, j + 2)].Get()));
    }
  }
}

template <int kDegree, bool kIsWeighted, size_t kRights>
HWY_NOINLINE void SolvePart(const PilotSystems& systems, size_t part, PilotSolutions& solutions) {
  constexpr int kSize = IndexOf(0, kDegree) + 1, kMore = kIsWeighted ? 2 : 0;
  const LaneTag d;
  const LaneVec inverse_count = hn::Div(hn::Set(d, 1.0), hn::Load(d, systems.count + part));
  const LaneVec radius = hn::Load(d, systems.radius + part);
  Stored moments[MonomialCount(2 * kDegree + kMore)];
  Normalize(systems.moments + part, 2 * kDegree + kMore, inverse_count, radius, moments);
  if constexpr (kIsWeighted) Weigh(moments, 2 * kDegree);
  LaneCholesky<kSize> factors;
  for (int q = 0, column = 0; q <= kDegree; ++q) {
    for (int b = 0; b <= q; ++b, ++column) {
      for (int p = q, row = column - b; p <= kDegree; ++p) {
        for (int a = 0; a <= p; ++a, ++row) {
          if (row >= column) factors.at(row, column).Set(moments[IndexOf(p - a + q - b, a + b)].Get());
        }
      }
    }
  }
  const auto are_fixed = factors.Compute();
  hn::Store(moments[0].Get(), d, solutions.weight.data() + part);
  LaneVec explained = hn::Zero(d);
  for (size_t right = 0; right < kRights; ++right) {
    Stored sums[MonomialCount(kDegree + kMore)], solved[kSize];
    Normalize(systems.rights[right] + part, kDegree + kMore, inverse_count, radius, sums);
    if constexpr (kIsWeighted) Weigh(sums, kDegree);
    for (int k = 0; k < kSize; ++k) solved[k].Set(sums[k].Get());
    factors.Solve(solved);
    for (int k = 0; k < kSize; ++k) {
      explained = hn::Add(explained, hn::Mul(solved[k].Get(), sums[k].Get()));
      hn::Store(solved[k].Get(), d, solutions.coefficients[right][static_cast<size_t>(k)].data() + part);
    }
  }
  hn::Store(explained, d, solutions.explained.data() + part);
  Stored fixed;
  fixed.Set(hn::IfThenElseZero(are_fixed, hn::Set(d, 1.0)));
  for (size_t lane = 0; lane < hn::Lanes(d); ++lane) solutions.are_fixed[part + lane] = fixed.lanes[lane] != 0.0;
}

template <int kDegree, bool kIsWeighted, size_t kRights>
void Solve(const PilotSystems& systems, PilotSolutions& solutions) {
  for (size_t part = 0; part < systems.size; part += hn::Lanes(LaneTag())) {
    SolvePart<kDegree, kIsWeighted, kRights>(systems, part, solutions);
  }
}

void SolveWeightedKernel(int degree, const PilotSystems& systems, PilotSolutions& solutions) {
  constexpr size_t kComponents = 3;
  degree == 2 ? Solve<2, true, kComponents>(systems, solutions) : Solve<3, true, kComponents>(systems, solutions);
}

void SolveUnweightedKernel(int degree, const PilotSystems& systems, PilotSolutions& solutions) {
  switch (degree) {
    case 2:
      return Solve<2, false, 1>(systems, solutions);
    case 4:
      return Solve<4, false, 1>(systems, solutions);
    default:
      return Solve<6, false, 1>(systems, solutions);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace curvd {
namespace {

HWY_EXPORT(SolveWeightedKernel);
HWY_EXPORT(SolveUnweightedKernel);

}  // namespace

void SolveWeighted(int degree, const PilotSystems& systems, PilotSolutions& solutions) {
  HWY_DYNAMIC_DISPATCH(SolveWeightedKernel)(degree, systems, solutions);
}

void SolveUnweighted(int degree, const PilotSystems& systems, PilotSolutions& solutions) {
  HWY_DYNAMIC_DISPATCH(SolveUnweightedKernel)(degree, systems, solutions);
}

}  // namespace curvd

#endif  // HWY_ONCE
