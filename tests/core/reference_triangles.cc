#include "tests/core/reference_triangles.h"

#include <Eigen/Dense>
#include <algorithm>

namespace curvd::testing {

using Eigen::Vector3d;

ReferenceCurvature ReferenceTriangles(const TestPoints& points, size_t i, const std::vector<int>& ids,
                                      std::span<const IdTriangle> triangles, const EstimatorOptions& options) {
  const Vector3d query = ToVector(points.positions[i]);
  ReferenceCurvature result;
  Vector3d mean_normal = Vector3d::Zero();
  for (const int id : ids) {
    mean_normal += ToVector(points.normals[id]) / static_cast<double>(ids.size());
    result.radius = std::max(result.radius, (ToVector(points.positions[id]) - query).norm());
  }
  const double w = options.average_normal_weight;
  Vector3d axes[2];
  TangentAxes(((1.0 - w) * ToVector(points.normals[i]) + w * mean_normal).normalized(), axes);
  ReferenceMeasures sum;
  const auto corner = [&](int id) {
    return ReferenceCorner{ToVector(points.positions[id]) - query, ToVector(points.normals[id])};
  };
  for (const auto& [a, b, c] : triangles) sum.AddTriangle(corner(a), corner(b), corner(c), axes);
  result.estimated = sum.area > 0.0;
  sum.ToCurvature(result);
  return result;
}

std::vector<IdTriangle> AllTriangles(const std::vector<int>& ids) {
  std::vector<IdTriangle> triangles;
  for (size_t a = 0; a < ids.size(); ++a) {
    for (size_t b = a + 1; b < ids.size(); ++b) {
      for (size_t c = b + 1; c < ids.size(); ++c) triangles.push_back({ids[a], ids[b], ids[c]});
    }
  }
  return triangles;
}

}  // namespace curvd::testing
