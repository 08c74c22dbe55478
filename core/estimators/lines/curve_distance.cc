#include "core/estimators/lines/curve_distance.h"

#include <algorithm>
#include <cmath>

namespace curvd {
namespace {

// How far the points of an even disc of radius 1 lie, in the root of the mean square, from the curve of each degree
// that comes nearest to them.
constexpr double kDiscDistance[kMaxFittedDegree + 1] = {1.0, 0.5, 0.22, 0.138, 0.096, 0.0719, 0.0565};
// Neighbors lie on a curve if they are off by at most so much of the disc's distance and of their noise; or if they are
// off by next to nothing of the former.
constexpr double kCurveDistance = 0.25, kCurveDistancePerNoise = 2.0, kHairDistance = 0.02;
// With fewer neighbors for each coefficient, they come near to some curve by chance.
constexpr double kLeastPerCoefficient = 2.5;
// Mean squares below this are rounding.
constexpr double kRounding = 1e-13;

struct Powers {
  int a, b;
};

struct MonomialPowers {
  Powers of[kMaxJetSize];

  constexpr MonomialPowers() : of{} {
    for (int degree = 0; degree <= kMaxFittedDegree; ++degree) {
      for (int b = 0; b <= degree; ++b) of[JetIndex(degree - b, b)] = {degree - b, b};
    }
  }
};
constexpr MonomialPowers kMonomials;

// What each monomial adds to those before it: polynomials that are orthogonal over the neighbors.
class OrthogonalPolynomials {
 public:
  // As many as are there before one vanishes at the neighbors.
  explicit OrthogonalPolynomials(const PolynomialSystem& system) : means_(system.means) {
    const int all = JetSize(system.degree);
    double factor[kMaxJetSize][kMaxJetSize];
    for (; size_ < all; ++size_) {
      const int c = size_;
      double rest = Mean(c, c);
      for (int r = 0; r < c; ++r) {
        double entry = Mean(c, r);
        for (int k = 0; k < r; ++k) entry -= factor[c][k] * factor[r][k] * squares_[k];
        factor[c][r] = entry / squares_[r];
        rest -= factor[c][r] * factor[c][r] * squares_[r];
      }
      if (!(rest > kRounding)) return;
      squares_[c] = rest;
      for (int r = 0; r < c; ++r) {
        double sum = -factor[c][r];
        for (int k = r + 1; k < c; ++k) sum -= factor[c][k] * coefficients_[k][r];
        coefficients_[c][r] = sum;
      }
      coefficients_[c][c] = 1.0;
    }
  }

  int size() const { return size_; }

  // How far the neighbors lie from the curve on which polynomial c vanishes.
  double DistanceFrom(int c) const {
    double gradient = 0.0;
    for (int r = 0; r <= c; ++r) {
      for (int s = 0; s <= c; ++s) {
        const Powers p = kMonomials.of[r], q = kMonomials.of[s];
        double product = 0.0;
        if (p.a > 0 && q.a > 0) product += p.a * q.a * means_[JetIndex(p.a + q.a - 2, p.b + q.b)];
        if (p.b > 0 && q.b > 0) product += p.b * q.b * means_[JetIndex(p.a + q.a, p.b + q.b - 2)];
        gradient += coefficients_[c][r] * coefficients_[c][s] * product;
      }
    }
    return gradient > 0.0 ? std::sqrt(squares_[c] / gradient) : 0.0;
  }

  // The mean square of the heights that the polynomials leave.
  double RestOf(const PolynomialSystem& system) const {
    double rest = system.squared_heights;
    for (int c = 0; c < size_; ++c) {
      double product = 0.0;
      for (int r = 0; r <= c; ++r) product += coefficients_[c][r] * system.heights[r];
      rest -= product * product / squares_[c];
    }
    return std::max(rest, 0.0);
  }

 private:
  double Mean(int c, int r) const {
    const Powers p = kMonomials.of[c], q = kMonomials.of[r];
    return means_[JetIndex(p.a + q.a, p.b + q.b)];
  }

  const double* const means_;
  int size_ = 0;
  double coefficients_[kMaxJetSize][kMaxJetSize];  // [c][r]: of monomial r
  double squares_[kMaxJetSize];                    // their mean squares
};

}  // namespace

int DeterminedDegree(const PolynomialSystem& system) {
  const OrthogonalPolynomials polynomials(system);
  const auto size = static_cast<double>(polynomials.size()), count = static_cast<double>(system.count);
  const double noise = count > size ? std::sqrt(polynomials.RestOf(system) * count / (count - size)) : 0.0;
  for (int c = 1; c < JetSize(system.degree); ++c) {
    const int degree = kMonomials.of[c].a + kMonomials.of[c].b;
    if (c >= polynomials.size()) return degree - 1;
    const bool may_be_chance = count < kLeastPerCoefficient * JetSize(degree);
    if (may_be_chance) continue;
    const double distance = polynomials.DistanceFrom(c), usual = kDiscDistance[degree];
    const bool is_noise = distance <= kCurveDistance * usual && distance <= kCurveDistancePerNoise * noise;
    if (is_noise || distance <= kHairDistance * usual) return degree - 1;
  }
  return system.degree;
}

}  // namespace curvd
