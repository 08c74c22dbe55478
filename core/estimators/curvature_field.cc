#include "core/estimators/curvature_field.h"

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
  }
  return "unknown";
}

PointCurvature UndefinedCurvature(PointStatus status) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  return {kNaN, kNaN, kNaN, kNaN, {kNaN, kNaN, kNaN}, {kNaN, kNaN, kNaN}, kNaN, status};
}

}  // namespace curvd
