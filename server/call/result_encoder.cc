#include "server/call/result_encoder.h"

#include <grpc/support/log.h>

#include <algorithm>
#include <array>
#include <vector>

#include "core/base/out_of_memory.h"
#include "core/base/page_pool.h"
#include "core/estimators/derived_quantities.h"
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

// A column of the contract and its place among the core's, which has the status among normals as well.
struct PackedColumn {
  const curvature::wire::ResultColumn* wire;
  size_t curvature_index;  // kColumnCount: none
  size_t normal_index;     // kNormalColumns.size(): none
  size_t derived_index;    // kDerivedColumns.size(): none
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

std::vector<PackedColumn> MatchColumns() {
  std::vector<PackedColumn> columns;
  for (const curvature::wire::ResultColumn& wire : curvature::wire::ResultColumns()) {
    const size_t curvature_index = ColumnIndex(wire.name), normal_index = ColumnIndex(wire.name, kNormalColumns);
    const size_t derived_index = DerivedIndex(wire.name);
    const bool is_derived = derived_index < kDerivedColumns.size();
    // A defect of the build.
    GPR_ASSERT(curvature_index < kColumnCount || normal_index < kNormalColumns.size() || is_derived);
    GPR_ASSERT(IsRight(curvature_index, kColumns, wire) && IsRight(normal_index, kNormalColumns, wire));
    GPR_ASSERT(!is_derived || wire.bytes_per_point == sizeof(float));
    columns.push_back({&wire, curvature_index, normal_index, derived_index});
  }
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
                                        const QuantitySet& quantities) {
  // The message, and what gRPC makes of it on its way.
  if (!ProcessPages().HasRoomFor(2 * count * ResultBytesPerPoint(quantities))) return OutOfMemoryError();
  ColumnPlaces places{};
  NormalPlaces normal_places{};
  DerivedPlaces derived_places{};
  curvature::wire::BulkWriter writer(EstimateCurvatureResponse::kResultFieldNumber);
  writer.AddNumber(ResultChunk::kFirstIndexFieldNumber, first);
  writer.AddNumber(ResultChunk::kPointCountFieldNumber, count);
  const bool has_curvature = results.curvature.size() > 0;
  for (const PackedColumn& column : PackedColumns()) {
    if (!IsWanted(column, quantities)) continue;
    const bool is_curvature = has_curvature && column.curvature_index < kColumnCount;
    char** place = is_curvature                                    ? &places[column.curvature_index]
                   : column.derived_index < kDerivedColumns.size() ? &derived_places[column.derived_index]
                                                                   : &normal_places[column.normal_index];
    writer.AddArray(column.wire->field, count * column.wire->bytes_per_point, place);
  }
  return writer.Finish([&] {
    if (has_curvature) {
      SplitField(results.curvature.span().subspan(first, count), places);
      DeriveColumns(results.curvature.span().subspan(first, count), derived_places);
    }
    if (results.normals.size() > 0) SplitNormals(results.normals.span().subspan(first, count), normal_places);
  });
}

}  // namespace curvd
