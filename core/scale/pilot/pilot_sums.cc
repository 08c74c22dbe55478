#include "core/scale/pilot/pilot_sums.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Geometry"
#include "core/scale/pilot/pilot_systems.h"

namespace curvd {
namespace {

using Eigen::Vector3d;

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
  AddMoments(batch, {.degree = degree,
                     .normal_degree = kNormalDegree,
                     .plain = &values_[kMoments],
                     .height = &values_[kHeights],
                     .normal = {normals, normals + kNormalCount, normals + 2 * kNormalCount}});
  const auto& [x, y, z] = batch.offset;
  for (size_t i = 0; i < batch.count; ++i) {
    values_[kHeightSquares] += z[i] * z[i];
    for (size_t axis = 0; axis < 3; ++axis) values_[kNormalHeights + axis] += z[i] * batch.normal[axis][i];
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

// The means of what lies in each sixth of the circle; the point itself where there is nothing. The loops over sixths
// become vector code.
PilotSums::Corners PilotSums::CornersOfSixths() const {
  std::array<std::array<double, kSectors>, kSectorValues> sums;
  for (size_t first = 0; first < kSectors; ++first) {
    const double* const a = &values_[kSectorSums + first * kSectorValues];
    const double* const b = &values_[kSectorSums + (first + 1) % kSectors * kSectorValues];
    for (size_t value = 0; value < kSectorValues; ++value) sums[value][first] = a[value] + b[value];
  }
  Corners corners;
  const auto& [count, x, y, z, nx, ny, nz] = sums;
  for (size_t i = 0; i < kSectors; ++i) {
    const double inverse = count[i] > 0.0 ? 1.0 / count[i] : 0.0;
    corners[0][i] = x[i] * inverse;
    corners[1][i] = y[i] * inverse;
    corners[2][i] = z[i] * inverse;
    const double length = std::sqrt(nx[i] * nx[i] + ny[i] * ny[i] + nz[i] * nz[i]);
    const double of_unit = count[i] > 0.0 ? 1.0 / length : 0.0;
    corners[3][i] = nx[i] * of_unit;
    corners[4][i] = ny[i] * of_unit;
    corners[5][i] = count[i] > 0.0 ? nz[i] * of_unit : 1.0;
  }
  return corners;
}

std::optional<PilotSums::Hexagrams> PilotSums::HexagramEstimate() const {
  const Corners corners = CornersOfSixths();
  Measures sum;
  for (size_t rotation = 0; rotation < 2; ++rotation) {
    for (size_t first = 0; first < 2; ++first) {
      Vector3d position[3], normal[3];
      for (size_t c = 0; c < 3; ++c) {
        const size_t i = (2 * first + 4 * c + rotation) % kSectors;
        position[c] = Vector3d(corners[0][i], corners[1][i], corners[2][i]);
        normal[c] = Vector3d(corners[3][i], corners[4][i], corners[5][i]);
      }
      AddTriangle(position, normal, sum);
    }
  }
  if (!(sum.area > 0.0)) return std::nullopt;
  const double mean = sum.mean / sum.area, gaussian = sum.gaussian / sum.area;
  return Hexagrams{{mean, 0.5 * (sum.xx - sum.yy) / sum.area, sum.xy / sum.area},
                   std::abs(mean) + std::sqrt(std::max(mean * mean - gaussian, 0.0))};
}

}  // namespace curvd
