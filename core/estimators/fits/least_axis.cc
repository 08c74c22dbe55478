#include "core/estimators/fits/least_axis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace curvd {
namespace {

using Vector = std::array<double, 3>;

Vector Cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double Dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace

void LeastAxis(const double* covariance, double* axis) {
  // Roots of the characteristic polynomial by Viete's formula, for the matrix less its mean eigenvalue (Smith,
  // "Eigenvalues of a symmetric 3 x 3 matrix", 1961).
  const double xy = covariance[1], xz = covariance[2], yz = covariance[4];
  const double mean = (covariance[0] + covariance[3] + covariance[5]) / 3.0;
  const double xx = covariance[0] - mean, yy = covariance[3] - mean, zz = covariance[5] - mean;
  const double spread = std::sqrt((xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz)) / 6.0);
  const double determinant = Dot({xx, xy, xz}, Cross({xy, yy, yz}, {xz, yz, zz}));
  const double cosine = determinant / (2.0 * spread * spread * spread);
  const double angle = std::acos(std::clamp(cosine, -1.0, 1.0)) / 3.0;
  const double least = 2.0 * spread * std::cos(angle + 2.0 * std::numbers::pi / 3.0);

  // The axis is normal to all rows of the matrix less the eigenvalue; the longest product of two is the most exact.
  const Vector rows[3] = {{xx - least, xy, xz}, {xy, yy - least, yz}, {xz, yz, zz - least}};
  Vector longest = {0.0, 0.0, 0.0};
  double squared = 0.0;
  for (int r = 0; r < 3; ++r) {
    const Vector product = Cross(rows[r], rows[(r + 1) % 3]);
    if (Dot(product, product) > squared) {
      longest = product;
      squared = Dot(product, product);
    }
  }
  if (squared <= 0.0) longest = {0.0, 0.0, squared = 1.0};
  for (int k = 0; k < 3; ++k) axis[k] = longest[static_cast<size_t>(k)] / std::sqrt(squared);
}

}  // namespace curvd
