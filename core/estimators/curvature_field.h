// Curvature at every point of a cloud: what an estimate returns.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/page_array.h"

namespace curvd {

// What became of one point. The values are those of curvature.v1.PointStatus.
enum class PointStatus : uint8_t {
  kOk = 1,
  kTooFewNeighbors = 2,
  kDegenerateArea = 3,
  kInvalidInput = 4,
  kInconsistentNormals = 5,
  kSingularFit = 6,
};
inline constexpr int kPointStatusEnd = 7;  // one past the largest value

// The word for a status in files and messages: "ok", "too_few_neighbors", ...
const char* PointStatusName(PointStatus status);

// Curvature at one point, in the caller's length unit. All values are NaN unless status is kOk, save that the radius of
// a radius neighborhood is always the requested one.
struct PointCurvature {
  float mean;      // (k1 + k2) / 2; positive where the surface bends away from its normal (a ball: 1 / r)
  float gaussian;  // from its own measure; near k1 * k2 but not defined by it
  float k1;        // <= k2
  float k2;
  std::array<float, 3> d1;  // unit direction of k1
  std::array<float, 3> d2;  // unit direction of k2; d1 x d2 points along the normal
  float radius;             // distance of the farthest neighbor, or the requested radius
  PointStatus status;
};

// A value whose every quantity is NaN.
PointCurvature UndefinedCurvature(PointStatus status);

// The result of an estimate, in the order of the points in the cloud.
struct CurvatureField {
  PageArray<PointCurvature> points;
  std::array<uint64_t, kPointStatusEnd> status_counts{};  // indexed by PointStatus
};

}  // namespace curvd
