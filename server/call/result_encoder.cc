#include "server/call/result_encoder.h"

#include <grpc/support/log.h>

#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "core/base/out_of_memory.h"
#include "core/base/page_pool.h"
#include "core/estimators/derived_quantities.h"
#include "core/estimators/normal_curvature.h"
#include "core/job/field_arrays.h"
#include "proto/bulk_message.h"
#include "proto/result_columns.h"

namespace curvd {
namespace {

using curvature::v1::EstimateCurvatureResponse;
using curvature::v1::ResultChunk;

constexpr size_t kMostMessageBytes = size_t{1} << 20;
// What a message has beside its arrays, at most.
constexpr size_t kMessageRoom = 128;

constexpr std::string_view kNormalCurvature = "normal_curvature";

// A column of the contract and its place among the core's, which has the status among normals as well.
struct PackedColumn {
  const curvature::wire::ResultColumn* wire;
  size_t curvature_index;  // kColumnCount: none
  size_t normal_index;     // kNormalColumns.size(): none
  size_t choice_index;     // kChoiceColumns.size(): none
  size_t derived_index;    // kDerivedColumns.size(): none
  bool is_normal_curvature;
};

size_t DerivedIndex(std::string_view name) {
  size_t i = 0;
  while (i < kDerivedColumns.size() && kDerivedColumns[i].name != name) ++i;
  return i;
}

template <size_t kCount>
bool IsRight(size_t index, const std::array<Column, kCount>& columns, const curvature::wire::ResultColumn& wire) {
  return index == kCount || columns[index].bytes() == wire.bytes_per_point;
}

PackedColumn Match(const curvature::wire::ResultColumn& wire) {
  const PackedColumn column{&wire,
                            ColumnIndex(wire.name),
                            ColumnIndex(wire.name, kNormalColumns),
                            ColumnIndex(wire.name, kChoiceColumns),
                            DerivedIndex(wire.name),
                            wire.name == kNormalCurvature};
  const bool is_derived = column.derived_index < kDerivedColumns.size() || column.is_normal_curvature;
  // A defect of the build.
  GPR_ASSERT(column.curvature_index < kColumnCount || column.normal_index < kNormalColumns.size() ||
             column.choice_index < kChoiceColumns.size() || is_derived);
  GPR_ASSERT(IsRight(column.curvature_index, kColumns, wire) && IsRight(column.normal_index, kNormalColumns, wire) &&
             IsRight(column.choice_index, kChoiceColumns, wire));
  GPR_ASSERT(!is_derived || wire.bytes_per_point == sizeof(float));
  return column;
}

std::vector<PackedColumn> MatchColumns() {
  std::vector<PackedColumn> columns;
  for (const curvature::wire::ResultColumn& wire : curvature::wire::ResultColumns()) columns.push_back(Match(wire));
  return columns;
}

const std::vector<PackedColumn>& PackedColumns() {
  static const auto& columns = *new std::vector<PackedColumn>(MatchColumns());
  return columns;
}

bool IsWanted(const PackedColumn& column, const QuantitySet& quantities) {
  const curvature::v1::Quantity quantity = column.wire->quantity;
  return quantity == curvature::v1::QUANTITY_UNSPECIFIED || quantities.Has(quantity);
}

// Where the arrays of a message are; nullptr: not wanted.
struct Places {
  ColumnPlaces curvature{};
  NormalPlaces normals{};
  ChoicePlaces choices{};
  DerivedPlaces derived{};
  char* normal_curvature = nullptr;

  char** Of(const PackedColumn& column, bool has_curvature) {
    if (has_curvature && column.curvature_index < kColumnCount) return &curvature[column.curvature_index];
    if (column.derived_index < kDerivedColumns.size()) return &derived[column.derived_index];
    if (column.choice_index < kChoiceColumns.size()) return &choices[column.choice_index];
    return column.is_normal_curvature ? &normal_curvature : &normals[column.normal_index];
  }
};

std::span<const Direction> DirectionsOf(const CallResults& results, size_t first, size_t count) {
  if (results.directions.size() == 0) return {&results.direction, 1};
  return results.directions.span().subspan(first, count);
}

}  // namespace

size_t ResultBytesPerPoint(const QuantitySet& quantities) {
  size_t bytes = 0;
  for (const PackedColumn& column : PackedColumns()) {
    if (IsWanted(column, quantities)) bytes += column.wire->bytes_per_point;
  }
  return bytes;
}

size_t ResultChunkPoints(const QuantitySet& quantities) {
  return std::min(kResultChunkPoints, (kMostMessageBytes - kMessageRoom) / ResultBytesPerPoint(quantities));
}

absl::StatusOr<grpc::Slice> PackResults(const CallResults& results, size_t first, size_t count,
                                        const QuantitySet& quantities, const PackedScale& scale) {
  // The message, and what gRPC makes of it on its way.
  if (!ProcessPages().HasRoomFor(2 * count * ResultBytesPerPoint(quantities))) return OutOfMemoryError();
  Places places;
  curvature::wire::BulkWriter writer(EstimateCurvatureResponse::kResultFieldNumber);
  writer.AddNumber(ResultChunk::kFirstIndexFieldNumber, first);
  writer.AddNumber(ResultChunk::kPointCountFieldNumber, count);
  if (scale.neighbor_count != 0) writer.AddNumber(ResultChunk::kNeighborCountFieldNumber, scale.neighbor_count);
  const PageArray<PointCurvature>& curvature = scale.smaller == nullptr ? results.curvature : *scale.smaller;
  const bool has_curvature = curvature.size() > 0;
  for (const PackedColumn& column : PackedColumns()) {
    if (!IsWanted(column, quantities)) continue;
    char** place = places.Of(column, has_curvature);
    writer.AddArray(column.wire->field, count * column.wire->bytes_per_point, place);
  }
  return writer.Finish([&] {
    if (has_curvature) {
      const auto points = curvature.span().subspan(first, count);
      SplitField(points, places.curvature);
      DeriveColumns(points, places.derived);
      if (places.normal_curvature != nullptr) {
        WriteNormalCurvatures(points, DirectionsOf(results, first, count), places.normal_curvature);
      }
    }
    if (results.normals.size() > 0) SplitNormals(results.normals.span().subspan(first, count), places.normals);
    if (results.choices.size() > 0) SplitChoices(results.choices.span().subspan(first, count), places.choices);
  });
}

}  // namespace curvd
