// Solves the normal equations of polynomials over several neighborhoods at once, with vectors.
#pragma once

#include <array>
#include <cstddef>

#include "core/scale/pilot/pilot_batch.h"

namespace curvd {

// x^i y^j has this index among monomials.
constexpr int IndexOf(int i, int j) { return (i + j) * (i + j + 1) / 2 + j; }

// Normal equations of polynomials over the tangent plane, whose unit of length is the radius of the neighborhood. Of
// each number there are kLanes, one of each neighborhood, after each other.
struct PilotSystems {
  static constexpr size_t kLanes = 8;
  static constexpr size_t kMostRights = 3;
  static constexpr size_t kMostSize = MonomialCount(6);

  // Of these, the first `size` neighborhoods are there.
  size_t size;
  const double* count;  // of neighbors, at least 1
  const double* radius;
  // Sums of monomials, of degrees up to twice that of the polynomials, and up to two more where the equations are
  // weighted.
  const double* moments;
  // Sums of monomials times what is fitted, of degrees up to that of the polynomials, or up to two more.
  std::array<const double*, kMostRights> rights;
};

struct PilotSolutions {
  using Lanes = std::array<double, PilotSystems::kLanes>;
  // Whether the neighbors fix the polynomial; otherwise all else means nothing.
  std::array<bool, PilotSystems::kLanes> are_fixed;
  alignas(64) std::array<std::array<Lanes, PilotSystems::kMostSize>, PilotSystems::kMostRights> coefficients;
  // The weight of all neighbors over their count, and the sum of squares that the polynomials explain, over that count.
  alignas(64) Lanes weight, explained;
};

// Fits a polynomial of degree 2 or 3 to each of three right sides, with weights 1 - x^2 - y^2. Operations are not
// fused: results are the same on every machine.
void SolveWeighted(int degree, const PilotSystems& systems, PilotSolutions& solutions);
// Fits a polynomial of degree 2, 4 or 6 to the first right side, without weights.
void SolveUnweighted(int degree, const PilotSystems& systems, PilotSolutions& solutions);

}  // namespace curvd
