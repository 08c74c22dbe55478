#include "server/call/result_encoder.h"

#include "core/job/field_arrays.h"
#include "curvature/v1/curvature.pb.h"
#include "proto/bulk_message.h"

namespace curvd {

using curvature::v1::EstimateCurvatureResponse;
using curvature::v1::ResultChunk;

grpc::Slice PackResults(const PageArray<PointCurvature>& points, size_t first, size_t count,
                        const QuantitySet& quantities) {
  const size_t scalars = count * sizeof(float), vectors = 3 * scalars;
  FieldArrays places;
  curvature::wire::BulkWriter writer(EstimateCurvatureResponse::kResultFieldNumber);
  const auto add = [&](int field, bool wanted, size_t bytes, char** place) {
    if (wanted) writer.AddArray(field, bytes, place);
  };
  writer.AddNumber(ResultChunk::kFirstIndexFieldNumber, first);
  writer.AddNumber(ResultChunk::kPointCountFieldNumber, count);
  add(ResultChunk::kStatusFieldNumber, true, count, &places.status);
  add(ResultChunk::kMeanCurvatureFieldNumber, quantities.mean, scalars, &places.mean);
  add(ResultChunk::kGaussianCurvatureFieldNumber, quantities.gaussian, scalars, &places.gaussian);
  add(ResultChunk::kK1FieldNumber, quantities.principal_curvatures, scalars, &places.k1);
  add(ResultChunk::kK2FieldNumber, quantities.principal_curvatures, scalars, &places.k2);
  add(ResultChunk::kD1FieldNumber, quantities.principal_directions, vectors, &places.d1);
  add(ResultChunk::kD2FieldNumber, quantities.principal_directions, vectors, &places.d2);
  add(ResultChunk::kRadiusFieldNumber, quantities.radius, scalars, &places.radius);
  return writer.Finish([&] { SplitField(points.span().subspan(first, count), places); });
}

}  // namespace curvd
