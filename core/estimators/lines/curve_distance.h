// Whether the neighbors of a point determine a polynomial over its tangent plane, given their noise.
//
// They do not determine one of degree k if they lie on an algebraic curve of degree k: a line, two lines or a conic,
// three lines. A curve that they are off by no more than by their noise is as good as one that they lie on: what tells
// the monomials apart is then noise.
#pragma once

#include "core/estimators/fits/jet_systems.h"

namespace curvd {

// Means over the neighbors, with x, y and their heights z above the plane in units of the radius; by JetIndex.
// Weighted, if the fit is.
struct PolynomialSystem {
  int degree;
  size_t count;            // of neighbors
  const double* means;     // of x^a y^b, up to twice the degree; the first is 1
  const double* heights;   // of z x^a y^b, up to the degree
  double squared_heights;  // of z^2
};

// The highest degree, at most that of the system, of which the neighbors determine a polynomial; 0: none.
int DeterminedDegree(const PolynomialSystem& system);

}  // namespace curvd
