#include "server/result_encoder.h"

#include <google/protobuf/io/coded_stream.h>
#include <grpc/slice.h>

#include <bit>
#include <cstdint>

#include "core/field_arrays.h"
#include "curvature/v1/curvature.pb.h"

namespace curvd {
namespace {

static_assert(std::endian::native == std::endian::little, "the wire format is little-endian");

using curvature::v1::EstimateCurvatureResponse;
using curvature::v1::ResultChunk;
using google::protobuf::io::CodedOutputStream;

// Wire types of https://protobuf.dev/programming-guides/encoding.
constexpr uint32_t kVarint = 0, kLengthDelimited = 2;

constexpr uint32_t Tag(int field, uint32_t wire_type) { return static_cast<uint32_t>(field) << 3 | wire_type; }

// A number that is zero is not written.
size_t NumberBytes(int field, uint64_t value) {
  if (value == 0) return 0;
  return CodedOutputStream::VarintSize32(Tag(field, kVarint)) + CodedOutputStream::VarintSize64(value);
}

uint8_t* WriteNumber(int field, uint64_t value, uint8_t* out) {
  if (value == 0) return out;
  out = CodedOutputStream::WriteVarint32ToArray(Tag(field, kVarint), out);
  return CodedOutputStream::WriteVarint64ToArray(value, out);
}

// Of tag and length, before that many bytes.
size_t PrefixBytes(int field, size_t length) {
  return CodedOutputStream::VarintSize32(Tag(field, kLengthDelimited)) + CodedOutputStream::VarintSize64(length);
}

uint8_t* WritePrefix(int field, size_t length, uint8_t* out) {
  out = CodedOutputStream::WriteVarint32ToArray(Tag(field, kLengthDelimited), out);
  return CodedOutputStream::WriteVarint64ToArray(length, out);
}

struct PackedArray {
  int field;
  bool wanted;
  size_t bytes;
  char* FieldArrays::*place;
};

}  // namespace

grpc::Slice PackResults(const PageArray<PointCurvature>& points, size_t first, size_t count,
                        const QuantitySet& quantities) {
  constexpr int kResult = EstimateCurvatureResponse::kResultFieldNumber;
  const size_t scalars = count * sizeof(float), vectors = 3 * scalars;
  const bool principal = quantities.principal_curvatures, directions = quantities.principal_directions;
  const PackedArray arrays[] = {
      {ResultChunk::kStatusFieldNumber, true, count, &FieldArrays::status},
      {ResultChunk::kMeanCurvatureFieldNumber, quantities.mean, scalars, &FieldArrays::mean},
      {ResultChunk::kGaussianCurvatureFieldNumber, quantities.gaussian, scalars, &FieldArrays::gaussian},
      {ResultChunk::kK1FieldNumber, principal, scalars, &FieldArrays::k1},
      {ResultChunk::kK2FieldNumber, principal, scalars, &FieldArrays::k2},
      {ResultChunk::kD1FieldNumber, directions, vectors, &FieldArrays::d1},
      {ResultChunk::kD2FieldNumber, directions, vectors, &FieldArrays::d2},
      {ResultChunk::kRadiusFieldNumber, quantities.radius, scalars, &FieldArrays::radius},
  };
  size_t chunk_bytes =
      NumberBytes(ResultChunk::kFirstIndexFieldNumber, first) + NumberBytes(ResultChunk::kPointCountFieldNumber, count);
  for (const PackedArray& array : arrays) {
    if (array.wanted) chunk_bytes += PrefixBytes(array.field, array.bytes) + array.bytes;
  }
  grpc_slice message = grpc_slice_malloc(PrefixBytes(kResult, chunk_bytes) + chunk_bytes);
  uint8_t* out = WritePrefix(kResult, chunk_bytes, GRPC_SLICE_START_PTR(message));
  out = WriteNumber(ResultChunk::kFirstIndexFieldNumber, first, out);
  out = WriteNumber(ResultChunk::kPointCountFieldNumber, count, out);
  FieldArrays places;
  for (const PackedArray& array : arrays) {
    if (!array.wanted) continue;
    out = WritePrefix(array.field, array.bytes, out);
    places.*array.place = reinterpret_cast<char*>(out);
    out += array.bytes;
  }
  SplitField(points.span().subspan(first, count), places);
  return {message, grpc::Slice::STEAL_REF};
}

}  // namespace curvd
