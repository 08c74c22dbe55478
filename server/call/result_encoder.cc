#include "server/call/result_encoder.h"

#include <grpc/support/log.h>

#include <vector>

#include "core/base/out_of_memory.h"
#include "core/base/page_pool.h"
#include "core/job/field_arrays.h"
#include "proto/bulk_message.h"
#include "proto/result_columns.h"

namespace curvd {
namespace {

using curvature::v1::EstimateCurvatureResponse;
using curvature::v1::ResultChunk;

// A column of the contract and its place among the core's.
struct PackedColumn {
  const curvature::wire::ResultColumn* wire;
  size_t index;
};

std::vector<PackedColumn> MatchColumns() {
  std::vector<PackedColumn> columns;
  for (const curvature::wire::ResultColumn& wire : curvature::wire::ResultColumns()) {
    const size_t index = ColumnIndex(wire.name);
    GPR_ASSERT(index < kColumnCount && kColumns[index].bytes() == wire.bytes_per_point);  // a defect of the build
    columns.push_back({&wire, index});
  }
  return columns;
}

const std::vector<PackedColumn>& PackedColumns() {
  static const auto& columns = *new std::vector<PackedColumn>(MatchColumns());
  return columns;
}

}  // namespace

absl::StatusOr<grpc::Slice> PackResults(const PageArray<PointCurvature>& points, size_t first, size_t count,
                                        const QuantitySet& quantities) {
  // The message, and what gRPC makes of it on its way.
  if (!ProcessPages().HasRoomFor(2 * count * kResultBytesPerPoint)) return OutOfMemoryError();
  ColumnPlaces places{};
  curvature::wire::BulkWriter writer(EstimateCurvatureResponse::kResultFieldNumber);
  writer.AddNumber(ResultChunk::kFirstIndexFieldNumber, first);
  writer.AddNumber(ResultChunk::kPointCountFieldNumber, count);
  for (const PackedColumn& column : PackedColumns()) {
    const curvature::v1::Quantity quantity = column.wire->quantity;
    if (quantity != curvature::v1::QUANTITY_UNSPECIFIED && !quantities.Has(quantity)) continue;
    writer.AddArray(column.wire->field, count * column.wire->bytes_per_point, &places[column.index]);
  }
  return writer.Finish([&] { SplitField(points.span().subspan(first, count), places); });
}

}  // namespace curvd
