// Curvature at every point of a cloud: what an estimate returns.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

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
  kOpposedNormals = 7,
  kOutlier = 8,
};
inline constexpr int kPointStatusEnd = 9;  // one past the largest value

// The word for a status in files and messages: "ok", "too_few_neighbors", ...
const char* PointStatusName(PointStatus status);

// Curvature at one point, in the caller's length unit. All values but the radius are NaN unless status is kOk. The
// radius is NaN where there is no neighborhood: with kTooFewNeighbors, kInvalidInput or kOutlier, and none by radius.
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

enum class ColumnType : uint8_t { kFloat32, kUint8 };

// A part of the result of a point, such as PointCurvature, that callers can ask for.
struct Column {
  std::string_view name;
  ColumnType type;
  size_t width;   // scalars
  size_t offset;  // in the result, bytes

  constexpr size_t bytes() const { return width * (type == ColumnType::kFloat32 ? sizeof(float) : sizeof(uint8_t)); }
};

// Every column of a field. What splits, packs, sends or receives fields goes by this table; a new quantity is a row
// here, a member above, and a field of the same name in curvature.v1.ResultChunk.
inline constexpr std::array kColumns = {
    Column{"status", ColumnType::kUint8, 1, offsetof(PointCurvature, status)},
    Column{"mean_curvature", ColumnType::kFloat32, 1, offsetof(PointCurvature, mean)},
    Column{"gaussian_curvature", ColumnType::kFloat32, 1, offsetof(PointCurvature, gaussian)},
    Column{"k1", ColumnType::kFloat32, 1, offsetof(PointCurvature, k1)},
    Column{"k2", ColumnType::kFloat32, 1, offsetof(PointCurvature, k2)},
    Column{"d1", ColumnType::kFloat32, 3, offsetof(PointCurvature, d1)},
    Column{"d2", ColumnType::kFloat32, 3, offsetof(PointCurvature, d2)},
    Column{"radius", ColumnType::kFloat32, 1, offsetof(PointCurvature, radius)},
};
inline constexpr size_t kColumnCount = kColumns.size();

// Returns the place of the column of that name, or columns.size() if there is none.
template <size_t kCount>
constexpr size_t ColumnIndex(std::string_view name, const std::array<Column, kCount>& columns) {
  size_t i = 0;
  while (i < kCount && columns[i].name != name) ++i;
  return i;
}
constexpr size_t ColumnIndex(std::string_view name) { return ColumnIndex(name, kColumns); }

// Bytes of all columns of one point.
constexpr size_t ColumnBytesPerPoint() {
  size_t bytes = 0;
  for (const Column& column : kColumns) bytes += column.bytes();
  return bytes;
}

// A value whose every float is NaN.
PointCurvature UndefinedCurvature(PointStatus status);

// The result of an estimate, in the order of the points in the cloud.
struct CurvatureField {
  PageArray<PointCurvature> points;
  std::array<uint64_t, kPointStatusEnd> status_counts{};  // indexed by PointStatus
};

}  // namespace curvd
