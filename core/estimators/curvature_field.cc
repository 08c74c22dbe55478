#include "core/estimators/curvature_field.h"

#include <cstring>
#include <limits>

namespace curvd {

const char* PointStatusName(PointStatus status) {
  switch (status) {
    case PointStatus::kOk:
      return "ok";
    case PointStatus::kTooFewNeighbors:
      return "too_few_neighbors";
    case PointStatus::kDegenerateArea:
      return "degenerate_area";
    case PointStatus::kInvalidInput:
      return "invalid_input";
    case PointStatus::kInconsistentNormals:
      return "inconsistent_normals";
    case PointStatus::kSingularFit:
      return "singular_fit";
    case PointStatus::kOpposedNormals:
      return "opposed_normals";
    case PointStatus::kOutlier:
      return "outlier";
  }
  return "unknown";
}

PointCurvature UndefinedCurvature(PointStatus status) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  PointCurvature point{};
  for (const Column& column : kColumns) {
    if (column.type != ColumnType::kFloat32) continue;
    for (size_t i = 0; i < column.width; ++i) {
      std::memcpy(reinterpret_cast<char*>(&point) + column.offset + i * sizeof(float), &kNaN, sizeof(float));
    }
  }
  point.status = status;
  return point;
}

}  // namespace curvd
