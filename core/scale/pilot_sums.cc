#include "core/scale/pilot_sums.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Geometry"
#include "core/scale/small_cholesky.h"

namespace curvd {
namespace {

using Eigen::Vector3d;

// x^i y^j has this index among monomials.
constexpr int IndexOf(int i, int j) { return (i + j) * (i + j + 1) / 2 + j; }

// Pivots of normal equations below this, where 1 is what an even neighborhood has, are rounding errors.
constexpr double kLeastPivot = 1e-10;
// Of the weights 1 - x^2 - y^2 over a disc, the mean of their squares over their mean.
constexpr double kMeanWeightInFit = 2.0 / 3.0;
// Neighbors more than a fit has coefficients, from which its residual says something.
constexpr double kLeastFreedom = 4.0;
// A jet of degree 6 of fewer neighbors for each coefficient mostly has pivots that lose digits.
constexpr double kLeastPerSexticCoefficient = 1.5;

// A neighborhood is a line if the standard deviation across it is at most so much of that along it, and at most so much
// of that along the normal: noise, or the line's own bend, could be all of its width.
constexpr double kLineWidth = 0.1, kLineWidthPerThickness = 2.0;
// What rounding of offsets to floats makes of a width of 0, squared, with room.
constexpr double kLineRounding = 1e-12;

constexpr size_t kSectorsOfHalf = 6;  // of the twelve sectors

// Which twelfth of the circle (x, y) lies in. Without branches, which would be taken by chance.
size_t SectorOf(double x, double y) {
  constexpr double kTan30 = 0.57735026918962576;
  const double a = std::abs(x), b = std::abs(y);
  const size_t within = (b < a * kTan30 ? 0 : 1) + (b * kTan30 < a ? 0 : 1);
  const bool is_above = y >= 0.0, is_right = x >= 0.0;
  return (is_above ? 0 : kSectorsOfHalf) + (is_above == is_right ? within : kSectorsOfHalf - 1 - within);
}

// Moments of a polynomial's degree, divided by those of unit length and by the weight of all neighbors.
template <int kDegree>
Eigen::Matrix<double, (kDegree + 1) * (kDegree + 2) / 2, (kDegree + 1) * (kDegree + 2) / 2> NormalMatrix(
    const double* moments) {
  constexpr int kSize = (kDegree + 1) * (kDegree + 2) / 2;
  Eigen::Matrix<double, kSize, kSize> matrix;
  for (int p = 0, row = 0; p <= kDegree; ++p) {
    for (int b = 0; b <= p; ++b, ++row) {
      for (int q = 0, column = 0; q <= kDegree; ++q) {
        for (int d = 0; d <= q; ++d, ++column) matrix(row, column) = moments[IndexOf(p - b + q - d, b + d)];
      }
    }
  }
  return matrix;
}

// Writes sums of monomials up to `degree`, of lengths in units of `radius`, divided by `count`.
void Normalize(const double* sums, int degree, double radius, double count, double* out) {
  double factor = 1.0 / count;
  for (int n = 0; n <= degree; ++n) {
    for (int j = 0; j <= n; ++j) out[IndexOf(n - j, j)] = sums[IndexOf(n - j, j)] * factor;
    factor /= radius;
  }
}

// The sums of (1 - x^2 - y^2) times monomials up to `degree`, of those of monomials alone.
void Weigh(const double* sums, int degree, double* out) {
  for (int n = 0; n <= degree; ++n) {
    for (int j = 0; j <= n; ++j) {
      const int i = n - j;
      out[IndexOf(i, j)] = sums[IndexOf(i, j)] - sums[IndexOf(i + 2, j)] - sums[IndexOf(i, j + 2)];
    }
  }
}

// The shape operator, over x and y, of a surface with the first fundamental form (e, f, g) and the second one (xx, xy,
// yy).
TangentShape ShapeOf(double e, double f, double g, double xx, double xy, double yy) {
  const double determinant = e * g - f * f;
  return {0.5 * (g * xx - 2.0 * f * xy + e * yy) / determinant, 0.5 * (g * xx - e * yy) / determinant,
          0.5 * ((e + g) * xy - f * (xx + yy)) / determinant};
}

// The same of a surface with these tangents and derivatives of its unit normal along them.
TangentShape ShapeOf(const Vector3d& tangent_x, const Vector3d& tangent_y, const Vector3d& normal_x,
                     const Vector3d& normal_y) {
  return ShapeOf(tangent_x.squaredNorm(), tangent_x.dot(tangent_y), tangent_y.squaredNorm(), tangent_x.dot(normal_x),
                 0.5 * (tangent_x.dot(normal_y) + tangent_y.dot(normal_x)), tangent_y.dot(normal_y));
}

// The same of a fit to the normals, whose value at the point has unit length.
template <typename Fit>
TangentShape ShapeOfNormals(const Fit& fit) {
  const Vector3d unit = fit.row(IndexOf(0, 0)), dx = fit.row(IndexOf(1, 0)), dy = fit.row(IndexOf(0, 1));
  const Vector3d tangent_x(1.0, 0.0, -unit.x() / unit.z()), tangent_y(0.0, 1.0, -unit.y() / unit.z());
  const auto along_sphere = [&](const Vector3d& d) -> Vector3d { return d - d.dot(unit) * unit; };
  return ShapeOf(tangent_x, tangent_y, along_sphere(dx), along_sphere(dy));
}

// A shape in units of `unit`.
TangentShape InUnits(const TangentShape& shape, double unit) {
  return {shape.mean / unit, shape.difference / unit, shape.twist / unit};
}

// Slopes of the shape operator at the origin of a regression's fit, in units of `squared_unit`: those of the symmetric
// part of the derivatives of the normals' x and y.
std::array<TangentShape, 2> SlopesOf(const Eigen::Matrix<double, IndexOf(0, 3) + 1, 3>& fit, double squared_unit) {
  const auto second = [&](int i, int j, int axis) {
    return (i == 1 ? 1.0 : 2.0) * fit(IndexOf(i, j), axis) / squared_unit;
  };
  const auto along = [&](int i, int j) {  // of x^i y^j along x, of x^(i-1) y^(j+1) along y
    return TangentShape{0.5 * (second(i, j, 0) + second(i - 1, j + 1, 1)),
                        0.5 * (second(i, j, 0) - second(i - 1, j + 1, 1)),
                        0.5 * (second(i - 1, j + 1, 0) + second(i, j, 1))};
  };
  return {along(2, 0), along(1, 1)};
}

// Corrected measures of triangles.
struct Measures {
  double area = 0.0, mean = 0.0, gaussian = 0.0;
  double xx = 0.0, xy = 0.0, yy = 0.0;
};

// Adds the measures of a triangle, turned so that its area is not negative (core/estimators/measures-inl.h).
void AddTriangle(const Vector3d* position, const Vector3d* normal, Measures& sum) {
  const Vector3d middle = (normal[0] + normal[1] + normal[2]) / 3.0;
  const Vector3d e1 = position[1] - position[0], e2 = position[2] - position[0];
  const Vector3d n1 = normal[1] - normal[0], n2 = normal[2] - normal[0];
  const double area = 0.5 * middle.dot(e1.cross(e2));
  const double sign = area < 0.0 ? -1.0 : 1.0;
  sum.area += sign * area;
  sum.mean += sign * 0.25 * middle.dot((normal[0] - normal[2]).cross(e1) + (normal[1] - normal[0]).cross(e2));
  sum.gaussian += sign * 0.5 * normal[0].dot(normal[1].cross(normal[2]));
  const Vector3d e1_middle = e1.cross(middle), e2_middle = e2.cross(middle);
  const Eigen::Matrix2d tensor =
      e2_middle.head<2>() * n1.head<2>().transpose() - e1_middle.head<2>() * n2.head<2>().transpose();
  sum.xx += sign * 0.5 * tensor(0, 0);
  sum.xy += sign * 0.25 * (tensor(0, 1) + tensor(1, 0));
  sum.yy += sign * 0.5 * tensor(1, 1);
}

}  // namespace

void PilotSums::AddUpTo(int degree, PilotBatch& batch) {
  values_[kCount] += static_cast<double>(batch.count);
  if (degree == kSexticDegree) values_[kSexticCount] += static_cast<double>(batch.count);
  double* const normals = &values_[kNormals];
  constexpr size_t kPerAxis = MonomialCount(kNormalDegree);
  AddMoments(batch,
             {degree, &values_[kMoments], &values_[kHeights], {normals, normals + kPerAxis, normals + 2 * kPerAxis}});
  const auto& [x, y, z] = batch.offset;
  for (size_t i = 0; i < batch.count; ++i) {
    values_[kHeightSquares] += z[i] * z[i];
    if (x[i] == 0.0 && y[i] == 0.0) continue;
    double* const sector = &values_[kSectorSums + SectorOf(x[i], y[i]) * kSectorValues];
    sector[0] += 1.0;
    for (size_t axis = 0; axis < 3; ++axis) {
      sector[1 + axis] += batch.offset[axis][i];
      sector[4 + axis] += batch.normal[axis][i];
    }
  }
}

PilotSums& PilotSums::operator+=(const PilotSums& other) {
  for (size_t i = 0; i < kValues; ++i) values_[i] += other.values_[i];
  return *this;
}

bool PilotSums::LieAlongLine() const {
  const double* const moments = &values_[kMoments];
  const auto mean = [&](double sum) { return sum / count(); };
  const double x = mean(moments[IndexOf(1, 0)]), y = mean(moments[IndexOf(0, 1)]), z = mean(values_[kHeights]);
  const double xx = mean(moments[IndexOf(2, 0)]) - x * x, xy = mean(moments[IndexOf(1, 1)]) - x * y;
  const double yy = mean(moments[IndexOf(0, 2)]) - y * y, zz = mean(values_[kHeightSquares]) - z * z;
  // The variances along and across the line are the eigenvalues of the tangent plane's covariance.
  const double half = 0.5 * (xx + yy), away = std::hypot(0.5 * (xx - yy), xy);
  const double along = half + away, across = half - away;
  if (across > kLineWidth * kLineWidth * along) return false;
  return across <= kLineWidthPerThickness * kLineWidthPerThickness * zz || across <= kLineRounding * along;
}

// The mean of what lies in a sixth of the circle that begins at the given twelfth; the point itself if there is
// nothing.
PilotSums::Corner PilotSums::CornerOf(size_t sector) const {
  const double* const first = &values_[kSectorSums + sector % kSectors * kSectorValues];
  const double* const second = &values_[kSectorSums + (sector + 1) % kSectors * kSectorValues];
  const double count = first[0] + second[0];
  if (count == 0.0) return {{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}};
  Corner corner{};
  double squared = 0.0;
  for (size_t axis = 0; axis < 3; ++axis) {
    corner.position[axis] = (first[1 + axis] + second[1 + axis]) / count;
    corner.normal[axis] = first[4 + axis] + second[4 + axis];
    squared += corner.normal[axis] * corner.normal[axis];
  }
  for (double& component : corner.normal) component /= std::sqrt(squared);
  return corner;
}

std::optional<PilotSums::Hexagrams> PilotSums::HexagramEstimate() const {
  Measures sum;
  for (size_t rotation = 0; rotation < 2; ++rotation) {
    for (size_t first = 0; first < 2; ++first) {
      Vector3d position[3], normal[3];
      for (size_t c = 0; c < 3; ++c) {
        const Corner corner = CornerOf(2 * first + 4 * c + rotation);
        position[c] = Vector3d(corner.position.data());
        normal[c] = Vector3d(corner.normal.data());
      }
      AddTriangle(position, normal, sum);
    }
  }
  if (!(sum.area > 0.0)) return std::nullopt;
  const double mean = sum.mean / sum.area, gaussian = sum.gaussian / sum.area;
  return Hexagrams{{mean, 0.5 * (sum.xx - sum.yy) / sum.area, sum.xy / sum.area},
                   std::abs(mean) + std::sqrt(std::max(mean * mean - gaussian, 0.0))};
}

template <int kDegree>
std::optional<PilotSums::NormalFit<kDegree>> PilotSums::FitNormals(double radius) const {
  constexpr int kSize = IndexOf(0, kDegree) + 1;
  if (count() < kSize + kLeastFreedom) return std::nullopt;
  double moments[MonomialCount(kMomentDegree)], weighted[MonomialCount(2 * kDegree)];
  Normalize(&values_[kMoments], 2 * kDegree + 2, radius, count(), moments);
  Weigh(moments, 2 * kDegree, weighted);
  SmallCholesky<kSize> factors;
  if (!factors.Compute(NormalMatrix<kDegree>(weighted), kLeastPivot)) return std::nullopt;
  NormalFit<kDegree> out;
  double explained = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    double sums[MonomialCount(kNormalDegree)];
    Normalize(&values_[kNormals + static_cast<size_t>(axis) * MonomialCount(kNormalDegree)], kDegree + 2, radius,
              count(), sums);
    Eigen::Matrix<double, kSize, 1> right;
    Weigh(sums, kDegree, right.data());
    out.coefficients.col(axis) = factors.Solve(right);
    explained += out.coefficients.col(axis).dot(right);
  }
  const Vector3d at_point = out.coefficients.row(IndexOf(0, 0));
  // The normals of a neighborhood that is no piece of a surface cancel out, or contradict the frame.
  constexpr double kLeastLength = 0.1, kLeastHeight = 0.2;
  const double length = at_point.norm();
  if (!(length > kLeastLength) || !(at_point.z() > kLeastHeight * length)) return std::nullopt;
  out.coefficients /= length;
  // The normals have unit length, so that the sum of their squares is that of the weights.
  const double freedom = 2.0 * (weighted[0] - kMeanWeightInFit * kSize / count());
  out.residual = std::sqrt(std::max(weighted[0] - explained, 0.0) / freedom);
  return out;
}

std::optional<PilotSums::Regression> PilotSums::RegressionEstimate(double radius) const {
  const auto fit = FitNormals<3>(radius);
  if (!fit.has_value()) return std::nullopt;
  return Regression{InUnits(ShapeOfNormals(fit->coefficients), radius), SlopesOf(fit->coefficients, radius * radius),
                    fit->residual};
}

std::optional<TangentShape> PilotSums::QuadraticRegressionEstimate(double radius) const {
  const auto fit = FitNormals<2>(radius);
  if (!fit.has_value()) return std::nullopt;
  return InUnits(ShapeOfNormals(fit->coefficients), radius);
}

template <int kDegree>
std::optional<PilotSums::Jet> PilotSums::FitJet(double radius) const {
  constexpr int kSize = IndexOf(0, kDegree) + 1;
  if (count() < kSize + 1) return std::nullopt;
  double moments[MonomialCount(2 * kDegree)];
  Normalize(&values_[kMoments], 2 * kDegree, radius, count(), moments);
  SmallCholesky<kSize> factors;
  if (!factors.Compute(NormalMatrix<kDegree>(moments), kLeastPivot)) return std::nullopt;
  Eigen::Matrix<double, kSize, 1> heights;
  Normalize(&values_[kHeights], kDegree, radius, count() * radius, heights.data());
  const Eigen::Matrix<double, kSize, 1> fit = factors.Solve(heights);
  const double squares = values_[kHeightSquares] / (count() * radius * radius) - fit.dot(heights);
  const double p = fit[IndexOf(1, 0)], q = fit[IndexOf(0, 1)], w = std::sqrt(1.0 + p * p + q * q);
  const double xx = -2.0 * fit[IndexOf(2, 0)] / w, xy = -fit[IndexOf(1, 1)] / w, yy = -2.0 * fit[IndexOf(0, 2)] / w;
  return Jet{InUnits(ShapeOf(1.0 + p * p, p * q, 1.0 + q * q, xx, xy, yy), radius),
             std::sqrt(std::max(squares, 0.0) * count() / (count() - kSize)) * radius};
}

std::optional<PilotSums::Jet> PilotSums::SexticEstimate(double radius) const {
  if (values_[kSexticCount] < count()) return std::nullopt;
  if (count() < kLeastPerSexticCoefficient * MonomialCount(kSexticDegree)) return std::nullopt;
  return FitJet<kSexticDegree>(radius);
}

template std::optional<PilotSums::Jet> PilotSums::FitJet<2>(double radius) const;
template std::optional<PilotSums::Jet> PilotSums::FitJet<4>(double radius) const;
template std::optional<PilotSums::Jet> PilotSums::FitJet<6>(double radius) const;

}  // namespace curvd
